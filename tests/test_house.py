"""Rules of the house that code can be held to: which way imports run, and that nothing but a seed is random."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "pipeline" / "pavemark"
ALL = [*sorted(PACKAGE.rglob("*.py")), *sorted((ROOT / "blender_addon").rglob("*.py")), ROOT / "render.py"]

FOUNDATION = {
    "records",
    "ground",
    "light",
    "scene",
    "plan",
    "plate",
    "layers",
    "files",
    "system",
    "errors",
    "assets",
    "calibration",
    "costs",
    "geometry",
    "colour",
    "cameras",
    "onnx",
    "page",
    "chart",
}
MIDDLE = {"background", "randomize", "compose", "labels"}
LEARNING = {"detect", "evaluate", "select"}
MAY_IMPORT = {
    **dict.fromkeys(FOUNDATION, FOUNDATION),
    **{room: FOUNDATION | {room} for room in MIDDLE},
    "detect": FOUNDATION | {"background", "detect"},
    "evaluate": FOUNDATION | {"detect", "evaluate"},
    "select": FOUNDATION | {"detect", "select"},
    "accuracy": FOUNDATION | MIDDLE | {"accuracy"},
    "training": FOUNDATION | {"background", "detect", "training"},
    "job": FOUNDATION | MIDDLE | {"job"},
    "study": FOUNDATION | LEARNING | {"background", "job", "training", "study"},
    "cli": FOUNDATION | LEARNING | {"job", "background", "accuracy", "training", "study", "cli"},
    "__main__": {"cli"},
}
BLENDER_MAY_IMPORT = {
    "cameras",
    "light",
    "scene",
    "ground",
    "plan",
    "plate",
    "layers",
    "geometry",
    "files",
    "system",
    "errors",
    "records",
    "colour",
}

PANEL_MAY_IMPORT = BLENDER_MAY_IMPORT | {"calibration", "costs", "job", "background", "randomize", "compose", "labels"}
"""The panel is to Blender what the command line is to a terminal."""

STAGE = {
    *("curves", "decals", "groups", "nodes", "paint", "patterns", "sheets"),
    *("renderer", "settings", "stage", "versions", "carpark"),
    *("casters", "floors", "passes", "relief", "sources"),
}
"""What draws. It knows nothing of the panel, so that a worker loads no more than it needs."""

CLOCKS = {PACKAGE / "job" / "clock.py", PACKAGE / "accuracy" / "clock.py"}
"""The files that read a clock: how long a run takes is shown, what a method costs is judged."""

DRAWN_FROM_A_SEED = {"Generator", "PCG64", "SeedSequence", "default_rng"}


def _name(path):
    return str(path.relative_to(ROOT))


def imports(tree):
    """(module, names) of every import of a file, relative ones left out: they stay in their package."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, ()
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module, tuple(alias.name for alias in node.names)


def rooms(tree):
    """The rooms of the package that a file imports from."""
    for module, names in imports(tree):
        head, *rest = module.split(".")
        if head == "pavemark":
            yield from [rest[0]] if rest else (name for name in names if not name.startswith("__"))


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=_name)
def test_imports_run_one_way(path):
    tree = ast.parse(path.read_text())
    room = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    heads = {module.split(".")[0] for module, _ in imports(tree)}
    assert not heads & {"bpy", "bmesh", "mathutils", "blender_addon"}
    assert set(rooms(tree)) <= MAY_IMPORT.get(room, set())
    assert not [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.level]


def relatives(tree):
    """The modules of the add-on that a file imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            yield from [node.module.split(".")[0]] if node.module else (alias.name for alias in node.names)


@pytest.mark.parametrize("path", sorted((ROOT / "blender_addon").rglob("*.py")), ids=_name)
def test_the_stage_knows_the_contract_only(path):
    tree = ast.parse(path.read_text())
    part = path.relative_to(ROOT / "blender_addon").parts[0].removesuffix(".py")
    assert set(rooms(tree)) <= (BLENDER_MAY_IMPORT if part in STAGE else PANEL_MAY_IMPORT)
    if part in STAGE - {"carpark"}:
        assert set(relatives(tree)) <= STAGE


def test_the_add_on_alone_loads_no_panel():
    """A worker imports the package for its renderer."""
    tree = ast.parse((ROOT / "blender_addon" / "__init__.py").read_text())
    assert [node for node in tree.body if not isinstance(node, (ast.FunctionDef, ast.Expr))] == []


def chance(tree):
    """What in a file makes its output depend on more than its input: (line, what)."""
    for module, names in imports(tree):
        head = module.split(".")[0]
        if head in {"random", "uuid", "secrets"}:
            yield 0, module
        if module == "numpy.random":
            yield from ((0, f"numpy.random.{name}") for name in names if name not in DRAWN_FROM_A_SEED)
        if head == "time":
            yield from ((0, f"time.{name}") for name in names)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            told = ast.unparse(node)
            if ast.unparse(node.value) in {"np.random", "numpy.random"} and node.attr not in DRAWN_FROM_A_SEED:
                yield node.lineno, told
            if told.startswith("time.") and told != "time.sleep":
                yield node.lineno, told
            if node.attr in {"now", "utcnow", "today"}:
                yield node.lineno, told
            if told == "os.urandom":
                yield node.lineno, told
        if isinstance(node, ast.Call):
            called = ast.unparse(node.func)
            unseeded = called.endswith(("default_rng", "SeedSequence", "PCG64")) and not node.args
            if called == "hash" or unseeded:
                yield node.lineno, called


@pytest.mark.parametrize("path", [path for path in ALL if path not in CLOCKS], ids=_name)
def test_nothing_but_a_seed_is_random(path):
    assert list(chance(ast.parse(path.read_text()))) == []


@pytest.mark.parametrize(
    "line",
    [
        "import random",
        "from random import shuffle",
        "import uuid",
        "np.random.rand(3)",
        "np.random.seed(1)",
        "from numpy.random import rand",
        "np.random.default_rng()",
        "time.time()",
        "time.perf_counter()",
        "from time import monotonic",
        "datetime.now()",
        "datetime.datetime.now()",
        "hash('a')",
        "os.urandom(4)",
    ],
)
def test_the_rule_finds_what_it_forbids(line):
    assert list(chance(ast.parse(line)))


@pytest.mark.parametrize("line", ["np.random.default_rng(7).random()", "np.random.Generator(np.random.PCG64(seed))"])
def test_the_rule_allows_what_has_a_seed(line):
    assert not list(chance(ast.parse(line)))
