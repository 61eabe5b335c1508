import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import suspid

LIBRARY = Path(suspid.__file__).parent
MODULES = {
    ".".join(path.relative_to(LIBRARY).with_suffix("").parts): ast.parse(path.read_text(encoding="utf-8"))
    for path in sorted(LIBRARY.rglob("*.py"))
    if path.parent == LIBRARY or path.stem != "__init__"
}

# Imports point from a later line to an earlier one; modules of one line may import each other's elders only.
LAYERS = [
    ["units", "errors"],
    ["values", "files"],
    [
        "suspension",
        "formats.tables",
        "formats.cells",
        "formats.encodings",
        "formats.signatures",
        "recordings",
        "exponentials",
        "formats.foreign",
        "formats.mdf_blocks",
        "formats.mdf_channels",
    ],
    ["formats.variables", "formats.dialects"],
    [
        "modes",
        "signals",
        "formats.layouts",
        "formats.matlab",
        "formats.hdf",
        "formats.uff",
        "formats.tdms",
        "formats.mdf",
        "formats.wav",
        "formats.parquet",
        "presets",
        "springs.unknowns",
        "springs.programs",
    ],
    ["mending.findings", "mending.conversions"],
    ["mending.stamps", "mending.gaps", "mending.inspection"],
    ["mending.ordering"],
    ["mending.clocks"],
    ["mending.placing"],
    ["formats.delimited", "formats.timing", "cleaning", "sensors"],
    ["simulation", "records", "cars", "denoising", "scalogram"],
    ["ridges", "likelihood"],
    ["selection"],
    ["identification"],
    ["events.bursts", "events.trials", "events.shared", "events.sketches"],
    ["events.doubts"],
    ["events.starts"],
    ["decays"],
    ["repeats"],
    ["springs.equations"],
    ["springs.polynomials"],
    ["springs.observations", "springs.alternatives"],
    ["springs.problem"],
    ["springs.suspects"],
    ["springs.verdicts"],
    ["reconstruction"],
    ["comparison"],
    ["modal_json", "car_json"],
    ["page.checks"],
    ["page.thinning", "page.judgement", "page.rows"],
    ["plots", "page.charts"],
    ["report_json", "page.figures"],
    ["reporting"],
    ["fleets.manifest", "fleets.records"],
    ["fleets.parts"],
    ["fleets.rows"],
    ["fleets.work", "fleets.folder"],
    ["fleets.engine"],
    ["fleet"],
    ["fleets.families", "fleets.trends", "fleets.vehicles"],
    ["fleet_summary"],
    ["commands.support"],
    ["commands.reading"],
    ["commands.measured"],
    ["commands.fleet"],
    ["cli"],
    ["__init__", "__main__"],
]
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}


def type_only(tree: ast.Module) -> set[int]:
    """Ids of the nodes below `if TYPE_CHECKING:`, which run for the type checker alone."""
    blocks = [n for n in ast.walk(tree) if isinstance(n, ast.If) and "TYPE_CHECKING" in ast.unparse(n.test)]
    return {id(node) for block in blocks for statement in block.body for node in ast.walk(statement)}


def imports(tree: ast.Module) -> list[str]:
    """Full names of all modules imported at run time, anywhere in the module."""
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
    return names


@pytest.mark.parametrize("name", MODULES)
class TestModules:
    def test_imports_point_one_way(self, name: str) -> None:
        assert name in LEVEL, f"suspid/{name}.py has no place in LAYERS of {Path(__file__).name}: give it one"
        for imported in imports(MODULES[name]):
            if imported.startswith("suspid."):
                other = imported.removeprefix("suspid.")
                assert other in LEVEL, f"suspid/{name}.py imports suspid.{other}, which has no place in LAYERS"
                assert LEVEL[other] < LEVEL[name], f"suspid/{name}.py must not import suspid.{other}: it is no elder"

    def test_nothing_is_printed(self, name: str) -> None:
        calls = [n for n in ast.walk(MODULES[name]) if isinstance(n, ast.Call) and ast.unparse(n.func) == "print"]
        assert not calls, f"suspid/{name}.py prints in line {calls[0].lineno}"

    def test_matplotlib_is_imported_by_plots_alone(self, name: str) -> None:
        if name not in {"plots", "commands.measured"}:
            assert not [i for i in imports(MODULES[name]) if i.split(".")[0] == "matplotlib"]

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
