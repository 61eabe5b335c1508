import ast
import inspect
import itertools
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import suspid

LIBRARY = Path(suspid.__file__).parent
MODULES = {
    ".".join(path.relative_to(LIBRARY).with_suffix("").parts): ast.parse(path.read_text(encoding="utf-8"))
    for path in sorted(LIBRARY.rglob("*.py"))
}
PACKAGES = sorted(path.parent.name for path in LIBRARY.glob("*/__init__.py"))


def package_of(name: str) -> str:
    """Return the package that a module belongs to; a module of the top level is its own."""
    return name.split(".")[0]


def type_only(tree: ast.Module) -> set[int]:
    """Return the ids of the nodes below `if TYPE_CHECKING:`, which only the type checker reads."""
    blocks = [n for n in ast.walk(tree) if isinstance(n, ast.If) and "TYPE_CHECKING" in ast.unparse(n.test)]
    return {id(node) for block in blocks for statement in block.body for node in ast.walk(statement)}


@cache
def imports(name: str) -> tuple[str, ...]:
    """Return the full names of all modules that a module imports at run time, anywhere in it."""
    tree = MODULES[name]
    skipped = type_only(tree)
    names: list[str] = []
    for node in ast.walk(tree):
        if id(node) in skipped:
            continue
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            if node.module == "suspid":
                names += [f"suspid.{alias.name}" for alias in node.names]
            else:
                names.append(node.module)
    return tuple(names)


def arrows(*, packages: bool) -> dict[str, set[str]]:
    """Return what each module, or each package, imports from the rest of the library."""
    graph: dict[str, set[str]] = {}
    for name in MODULES:
        if name in ("__init__", "__main__"):
            continue
        others = [other.removeprefix("suspid.") for other in imports(name) if other.startswith("suspid.")]
        source = package_of(name) if packages else name
        targets = {package_of(other) if packages else other for other in others}
        graph.setdefault(source, set()).update(targets - {source})
    return graph


class TestLayers:
    def test_packages_import_in_one_direction(self) -> None:
        assert list(TopologicalSorter(arrows(packages=True)).static_order())

    @pytest.mark.parametrize("package", PACKAGES)
    def test_modules_of_a_package_import_in_one_direction(self, package: str) -> None:
        inside = {n: {o for o in others if package_of(o) == package} for n, others in arrows(packages=False).items()}
        assert list(
            TopologicalSorter({n: others for n, others in inside.items() if package_of(n) == package}).static_order()
        )

    @pytest.mark.parametrize("name", MODULES)
    def test_other_packages_are_used_through_what_they_export(self, name: str) -> None:
        for imported in imports(name):
            package, _, module = imported.removeprefix("suspid.").partition(".")
            # Each module of words is a subject of its own, which its users import by name.
            if imported.startswith("suspid.") and package not in (package_of(name), "words"):
                assert not module, f"suspid/{name}.py imports {imported}: import from suspid.{package} what it exports"

    @pytest.mark.parametrize("package", PACKAGES)
    def test_a_package_says_what_lives_there_and_what_it_exports(self, package: str) -> None:
        tree = MODULES[f"{package}.__init__"]
        text = ast.get_docstring(tree) or ""
        assert 1 <= len(text.splitlines()) <= 12
        names = {a.name for n in tree.body if isinstance(n, ast.ImportFrom) for a in n.names}
        lists = [n for n in tree.body if isinstance(n, ast.Assign) and ast.unparse(n.targets[0]) == "__all__"]
        assert names == set(ast.literal_eval(lists[0].value) if lists else ())

    @pytest.mark.parametrize("package", PACKAGES)
    def test_no_package_is_named_like_an_exported_function(self, package: str) -> None:
        assert package not in suspid.__all__


def constants(tree: ast.Module) -> list[str]:
    """Return the names of the constants that a module assigns, those of tuples as well."""
    targets = [
        target
        for node in tree.body
        if isinstance(node, ast.Assign | ast.AnnAssign)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
    ]
    names = [name for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)]
    return [name.id for name in names if name.id.isupper()]


def numeric(value: ast.expr) -> bool:
    """Return whether an expression holds numbers, alone or in tuples, and nothing else."""
    leaves = [n for n in ast.walk(value) if isinstance(n, ast.Constant | ast.Name | ast.Call)]
    return all(isinstance(n, ast.Constant) and type(n.value) in (int, float) for n in leaves) and bool(leaves)


class TestConstants:
    def test_a_constant_stands_once(self) -> None:
        """One name has one value and one owner; other modules import it."""
        owners: dict[str, list[str]] = {}
        for module, tree in MODULES.items():
            for constant in constants(tree):
                owners.setdefault(constant, []).append(module)
        assert {constant: modules for constant, modules in owners.items() if len(modules) > 1} == {}

    def test_names_differ_by_more_than_an_underscore(self) -> None:
        names = [constant for tree in MODULES.values() for constant in constants(tree)]
        assert len({name.replace("_", "") for name in names}) == len(set(names))

    @pytest.mark.parametrize("name", MODULES)
    def test_a_number_stands_beside_its_reason(self, name: str) -> None:
        """The comment is in the line itself, or above the group of lines in which the constant stands."""
        lines = (LIBRARY / (name.replace(".", "/") + ".py")).read_text(encoding="utf-8").splitlines()
        for node in MODULES[name].body:
            if isinstance(node, ast.Assign | ast.AnnAssign) and node.value and numeric(node.value):
                above = lines[: node.lineno - 1]
                group = list(itertools.takewhile(str.strip, reversed(above)))
                reasons = [line for line in group if line.startswith("#")]
                said = reasons or "  # " in lines[node.lineno - 1] or not constants(ast.Module([node], []))
                assert said, f"suspid/{name.replace('.', '/')}.py line {node.lineno}: no reason beside the number"


@pytest.mark.parametrize("name", MODULES)
class TestModules:
    def test_nothing_is_printed(self, name: str) -> None:
        calls = [n for n in ast.walk(MODULES[name]) if isinstance(n, ast.Call) and ast.unparse(n.func) == "print"]
        assert not calls, f"suspid/{name}.py prints in line {calls[0].lineno}"

    def test_matplotlib_is_imported_by_plots_alone(self, name: str) -> None:
        helpers = {"reporting.axes", "reporting.pictures", "reporting.svg", "results"}
        if not name.startswith("reporting.plot_") and name not in {*helpers, "cli.measured"}:
            assert not [i for i in imports(name) if i.split(".")[0] == "matplotlib"]

    def test_no_method_rebinds_self(self, name: str) -> None:
        for function in [n for n in ast.walk(MODULES[name]) if isinstance(n, ast.FunctionDef)]:
            if function.name in {"__init__", "__post_init__"}:
                continue
            for node in ast.walk(function):
                stored = isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store | ast.Del)
                forced = isinstance(node, ast.Call) and ast.unparse(node.func) == "object.__setattr__"
                assert not forced, f"suspid/{name}.py line {function.lineno}: {function.name} forces an attribute"
                if stored:
                    target = ast.unparse(node).split(".")[0]
                    assert target != "self", f"suspid/{name}.py line {function.lineno}: {function.name} assigns to self"

    def test_no_function_takes_any_keyword(self, name: str) -> None:
        bodies = [MODULES[name].body, *(n.body for n in MODULES[name].body if isinstance(n, ast.ClassDef))]
        for function in [n for body in bodies for n in body if isinstance(n, ast.FunctionDef)]:
            assert function.args.kwarg is None, f"suspid/{name}.py: {function.name} takes any keyword"


class TestPublicNames:
    @pytest.mark.parametrize("name", suspid.__all__)
    def test_documented_with_an_example(self, name: str) -> None:
        thing = getattr(suspid, name)
        text = inspect.getdoc(thing) or ""
        assert text, f"{name} has no docstring"
        if isinstance(thing, type) and issubclass(thing, Exception):
            return
        # A result that functions return is shown in their examples.
        made_by_user = not isinstance(thing, type) or name in {"Strut", "Suspension", "ModalSet"}
        if made_by_user:
            assert "Examples\n--------\n" in text, f"{name} has no Examples section"
            assert ">>> " in text, f"{name} has no example"

    def test_names_stand_once(self) -> None:
        assert len(suspid.__all__) == len(set(suspid.__all__))


class TestStart:
    @pytest.mark.parametrize("package", ["control", "cvxpy", "pywt", "matplotlib", "scipy.signal", "scipy.stats"])
    def test_import_suspid_leaves_the_heavy_packages_out(self, package: str) -> None:
        code = f"import sys, suspid; sys.exit({package!r} in sys.modules)"
        assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0, f"{package} is imported"
