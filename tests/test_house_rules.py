import ast
import itertools
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache, cached_property
from graphlib import TopologicalSorter
from pathlib import Path
from types import FunctionType

import pytest

import suspid
from suspid.cli.option_names import ARGUMENTS_AS_OPTIONS

LIBRARY = Path(suspid.__file__).parent
PACKAGES = sorted(path.parent.name for path in LIBRARY.glob("*/__init__.py"))


@cache
def modules() -> dict[str, ast.Module]:
    """Return the syntax tree of each module of the library by its name."""
    return {
        ".".join(path.relative_to(LIBRARY).with_suffix("").parts): ast.parse(path.read_text(encoding="utf-8"))
        for path in sorted(LIBRARY.rglob("*.py"))
    }


@cache
def nodes() -> list[tuple[str, ast.AST]]:
    """Return the nodes of all modules, each with the name of its module."""
    return [(name, node) for name, tree in modules().items() for node in ast.walk(tree)]


@pytest.fixture(scope="module", autouse=True)
def nothing_is_kept() -> Iterator[None]:
    """Leave no tree behind: other tests collect garbage often, and these are half a million nodes."""
    yield
    for cached in (modules, nodes, imports):
        cached.cache_clear()


def place(name: str) -> str:
    """Return where a module stands in the project."""
    return f"suspid/{name.replace('.', '/')}.py"


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
    tree = modules()[name]
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
    for name in modules():
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

    def test_other_packages_are_used_through_what_they_export(self) -> None:
        for name in modules():
            for imported in imports(name):
                package, _, module = imported.removeprefix("suspid.").partition(".")
                # Each module of words is a subject of its own, which its users import by name.
                if imported.startswith("suspid.") and package not in (package_of(name), "words"):
                    assert not module, f"{place(name)} imports {imported}: import from suspid.{package} what it exports"

    @pytest.mark.parametrize("package", PACKAGES)
    def test_a_package_says_what_lives_there_and_what_it_exports(self, package: str) -> None:
        tree = modules()[f"{package}.__init__"]
        text = ast.get_docstring(tree) or ""
        assert 1 <= len(text.splitlines()) <= 12
        # What is imported `as` itself is for other packages alone.
        names = {a.name for n in tree.body if isinstance(n, ast.ImportFrom) for a in n.names if a.asname is None}
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
        for module, tree in modules().items():
            for constant in constants(tree):
                owners.setdefault(constant, []).append(module)
        assert {constant: modules for constant, modules in owners.items() if len(modules) > 1} == {}

    def test_names_differ_by_more_than_an_underscore(self) -> None:
        names = [constant for tree in modules().values() for constant in constants(tree)]
        assert len({name.replace("_", "") for name in names}) == len(set(names))

    def test_a_number_stands_beside_its_reason(self) -> None:
        """The comment is in the line itself, or above the group of lines in which the constant stands."""
        for name, node in [(name, node) for name, tree in modules().items() for node in tree.body]:
            if isinstance(node, ast.Assign | ast.AnnAssign) and node.value and numeric(node.value):
                lines = (LIBRARY.parent / place(name)).read_text(encoding="utf-8").splitlines()
                above = lines[: node.lineno - 1]
                group = list(itertools.takewhile(str.strip, reversed(above)))
                reasons = [line for line in group if line.startswith("#")]
                said = reasons or "  # " in lines[node.lineno - 1] or not constants(ast.Module([node], []))
                assert said, f"{place(name)} line {node.lineno}: no reason beside the number"


class TestWords:
    """Turns of phrase that no engineer would use stand neither in messages nor in docstrings, comments and manuals."""

    STRUCK = re.compile(r"\bso many\b|\bso often\b|\bon the heels of\b|\bhalves apart\b", re.IGNORECASE)

    def test_are_those_of_the_field(self) -> None:
        root = LIBRARY.parent
        texts = [*LIBRARY.rglob("*.py"), *LIBRARY.rglob("*.j2"), root / "README.md", *(root / ".manual").glob("*.md")]
        found = {
            str(path.relative_to(root)): names
            for path in texts
            if (names := self.STRUCK.findall(" ".join(path.read_text(encoding="utf-8").replace("\n# ", " ").split())))
        }
        assert found == {}


def said(node: ast.AST) -> str:
    """Return the text of a string, with braces for what is filled in and without calls; empty for anything else."""
    if isinstance(node, ast.JoinedStr):
        text = "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
    else:
        text = node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""
    return re.sub(r"\w\((?:[^()]|\([^()]*\))*\)", "", text)


class TestMessages:
    """The command writes an argument as its option because errors and remarks hold it as an `Argument`."""

    IN_TEXT = re.compile(rf"(?<![\w.'-])({'|'.join(ARGUMENTS_AS_OPTIONS)})=(?![= ])")

    OPTION = re.compile(rf"(?<![\w-])({'|'.join(set(ARGUMENTS_AS_OPTIONS.values()))})(?![\w-])")

    # Digits of a share in per cent that becomes 1e+02: `suspid.words.percent` writes 100.
    PER_CENT = re.compile(r":\.[12]g\} ?%")

    def test_no_share_in_per_cent_has_an_exponent(self) -> None:
        found = [path.name for path in LIBRARY.rglob("*.py") if self.PER_CENT.search(path.read_text(encoding="utf-8"))]
        assert found == []

    def texts(self) -> list[tuple[str, str, str]]:
        """Return module, place and text of all strings but docstrings."""
        docstrings = {id(n.value) for _, n in nodes() if isinstance(n, ast.Expr)}
        strings = [(n, node) for n, node in nodes() if isinstance(node, ast.Constant | ast.JoinedStr)]
        return [
            (name, f"{place(name)} line {node.lineno}", said(node))
            for name, node in strings
            if id(node) not in docstrings
        ]

    def test_arguments_are_no_part_of_the_text(self) -> None:
        assert [where for _, where, text in self.texts() if self.IN_TEXT.search(text)] == []

    def test_options_are_no_part_of_the_text(self) -> None:
        """In Python there are none; the commands alone may write them."""
        found = [where for name, where, text in self.texts() if self.OPTION.search(text) and package_of(name) != "cli"]
        assert found == []


class TestModules:
    def test_nothing_is_printed(self) -> None:
        for name, node in nodes():
            if isinstance(node, ast.Call):
                assert ast.unparse(node.func) != "print", f"{place(name)} prints in line {node.lineno}"

    def test_words_that_are_functions_have_a_known_type(self) -> None:
        for name, node in nodes():
            if name.startswith("words.") and isinstance(node, ast.Tuple):
                bare = [one.lineno for one in node.elts if isinstance(one, ast.Lambda)]
                assert not bare, f"{place(name)}: pass the lambda of line {bare[0]} to `sentence`"

    def test_matplotlib_is_imported_by_plots_alone(self) -> None:
        helpers = {"reporting.axes", "reporting.pictures", "reporting.svg", "results", "cli.measured"}
        others = [name for name in modules() if not name.startswith("reporting.plot_") and name not in helpers]
        assert [name for name in others if any(i.split(".")[0] == "matplotlib" for i in imports(name))] == []

    def test_no_method_rebinds_self(self) -> None:
        functions = [(name, node) for name, node in nodes() if isinstance(node, ast.FunctionDef)]
        for name, function in functions:
            if function.name in {"__init__", "__post_init__"}:
                continue
            where = f"{place(name)} line {function.lineno}: {function.name}"
            for node in ast.walk(function):
                stored = isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store | ast.Del)
                forced = isinstance(node, ast.Call) and ast.unparse(node.func) == "object.__setattr__"
                assert not forced, f"{where} forces an attribute"
                if stored:
                    assert ast.unparse(node).split(".")[0] != "self", f"{where} assigns to self"

    def test_no_function_takes_any_keyword(self) -> None:
        for name, tree in modules().items():
            bodies = [tree.body, *(n.body for n in tree.body if isinstance(n, ast.ClassDef))]
            for function in [n for body in bodies for n in body if isinstance(n, ast.FunctionDef)]:
                assert function.args.kwarg is None, f"{place(name)}: {function.name} takes any keyword"


class TestPublicNames:
    @pytest.mark.parametrize("name", suspid.__all__)
    def test_documented_with_an_example(self, name: str) -> None:
        thing = getattr(suspid, name)
        text = thing.__doc__ or ""
        assert "Examples\n" in text, f"{name} has no Examples section"
        assert ">>> " in text, f"{name} has no example"

    @pytest.mark.parametrize("name", [name for name in suspid.__all__ if isinstance(getattr(suspid, name), type)])
    def test_what_a_type_offers_has_an_example_of_its_own(self, name: str) -> None:
        own = [one for one in getattr(suspid, name).__mro__ if one.__module__.startswith("suspid")]
        for member, found in [item for one in own for item in vars(one).items()]:
            called = isinstance(found, classmethod | staticmethod | FunctionType)
            if not member.startswith("_") and (called or isinstance(found, property | cached_property)):
                assert ">>> " in (found.__doc__ or ""), f"{name}.{member} has no example"

    def test_names_stand_once(self) -> None:
        assert len(suspid.__all__) == len(set(suspid.__all__))


class TestStart:
    def test_import_suspid_leaves_the_heavy_packages_out(self) -> None:
        code = "import sys, suspid; print(*sys.modules)"
        loaded = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split()
        assert set(loaded) & {"control", "cvxpy", "pywt", "matplotlib", "scipy.signal", "scipy.stats"} == set()

    def test_an_analysis_takes_samples_and_no_response(self) -> None:
        """A field of a result that is read as a response imports python-control: a second of a first command."""
        calls = [(name, node) for name, node in nodes() if isinstance(node, ast.Call)]
        for name, call in calls:
            if name.startswith(("analysis.", "decays.")) and ast.unparse(call.func) == "as_signal":
                taken = [one for one in call.args if isinstance(one, ast.Attribute)]
                fields = [one.attr for one in taken if one.attr in {"response", "fitted", "residual"}]
                assert not fields, f"{place(name)} line {call.lineno}: take `held(found, {fields[0]!r})`"


def test_the_top_level_holds_what_belongs_there() -> None:
    try:
        listed = subprocess.run(
            ["git", "ls-files", "-z"], cwd=LIBRARY.parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("this is no checkout")
    top = {path.partition("/")[0] for path in listed.stdout.split("\0") if path}
    folders = {"examples", "suspid", "tests", "validation"}
    assert {name for name in top if not name.startswith(".")} <= {"LICENSE", "README.md", "pyproject.toml", *folders}
