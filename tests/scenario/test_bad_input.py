"""Bad input: every mistake is one line with file, line, key, value and remedy."""

from __future__ import annotations

import re

import pytest

from gm_ompl.errors import ScenarioError
from tests.scenario.bad import Bad, LoadChanged

HULL = "{hull: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}"
HALF_STARTED = "  max_normal_force: 10\n  start: "

PATH_CASES = [
    # Words and numbers that other readers take for something else.
    Bad("mass: 1", "mass: yes", 5, "object.mass", "finite number"),
    Bad("mass: 1", "mass: 1:30", 5, "object.mass", "finite number"),
    Bad("mass: 1", "mass: 1_000", 5, "object.mass", "finite number"),
    Bad("mass: 1", "mass: 0x10", 5, "object.mass", "finite number"),
    Bad("mass: 1", 'mass: "1"', 5, "object.mass", "finite number"),
    Bad("mass: 1", "mass: 1 kg", 5, "object.mass", "no unit"),
    Bad("mass: 1", "mass: .nan", 5, "object.mass", "finite number"),
    Bad("mass: 1", "mass: .inf", 5, "object.mass", "finite number"),
    Bad("mass: 1", "mass: 1e400", 5, "object.mass", "finite number"),
    Bad("mass: 1", "mass: true", 5, "object.mass", "finite number"),
    Bad("mass: 1", "mass:", 5, "object.mass", "finite number"),
    Bad("mass: 1", "mass: " + "9" * 5000, 5, "object.mass", "finite number"),
    Bad("floor: true", "floor: on", 14, "environment.floor", "true or false"),
    Bad("name: test/tumble", "name: 12", 2, "name", "text"),
    Bad("name: test/tumble", 'name: ""', 2, "name", "not be empty"),
    # Keys.
    Bad("mass: 1", "mas: 1", 5, "object.mas", "did you mean 'mass'?"),
    Bad("mass: 1", "colour: 1", 5, "object.colour", "keys here: shape, mass"),
    Bad("mass: 1", "mass: 1\n  mass: 2", 6, "object.mass", "given twice"),
    Bad("  mass: 1\n", "", 3, "object.mass", "missing; add it, for example mass: 1"),
    Bad("gravity: 9.8", "<<: {a: 1}", 7, "<<", "unknown key"),
    Bad("gravity: 9.8", "? [1, 2]\n: 3", 7, "", "plain word"),
    Bad("environment: 0.5", "enviroment: 0.5", 6, "friction.enviroment", "'environment'"),
    Bad("cone_edges", "cone_edge", 22, "mechanics.cone_edge", "'cone_edges'"),
    Bad("towards", "toward", 20, "motion.path.0.tumble.toward", "'towards'"),
    Bad("{box: {min", "{bx: {min", 16, "environment.obstacles.wall.bx", "'box'"),
    # Ranges.
    Bad("mass: 1", "mass: -1", 5, "object.mass", "> 0"),
    Bad("mass: 1", "mass: 1e16", 5, "object.mass", "from -1e+15 to 1e+15"),
    Bad("mass: 1", "mass: 1e-16", 5, "object.mass", ">= 1e-15"),
    Bad("[5, 5, 10]", "[5, 1e16, 10]", 4, "object.shape.box.1", "from -1e+15 to 1e+15"),
    Bad("[5, 5, 10]", "[5, 1e-5, 10]", 4, "object.shape.box.1", "1e-05 of the longest side"),
    Bad("environment: 0.5", "environment: 1e5", 6, "friction.environment", "<= 10000"),
    Bad("max_normal_force: 10", "max_normal_force: 1e6", 11, "fingers.max_normal_force",
        "weight, 9.8"),
    Bad("[5, 5, 10]", "[5, 0, 10]", 4, "object.shape.box.1", "> 0"),
    Bad("[5, 5, 10]", "[5, 5]", 4, "object.shape.box", "at least 3 entries"),
    Bad("[5, 5, 10]", "[5, 5, 10, 1]", 4, "object.shape.box", "at most 3 entries"),
    Bad("[5, 5, 10]", "5", 4, "object.shape.box", "list in square brackets"),
    Bad("finger: 0.7", "finger: -0.7", 6, "friction.finger", ">= 0"),
    Bad("finger: 0.7", "finger: [0.7]", 6, "friction.finger", "one entry per finger: 2"),
    Bad("gravity: 9.8", "gravity: -9.8", 7, "gravity", ">= 0"),
    Bad("count: 2", "count: 6", 9, "fingers.count", "<= 5"),
    Bad("count: 2", "count: -1", 9, "fingers.count", ">= 0"),
    Bad("count: 2", "count: 2.0", 9, "fingers.count", "whole number"),
    Bad("radius: 1", "radius: 0", 10, "fingers.radius", "> 0"),
    Bad("radius: 1", "radius: [1, 1, 1]", 10, "fingers.radius", "one entry per finger: 2"),
    Bad("radius: 1", "radius: [1, x]", 10, "fingers.radius.1", "finite number"),
    Bad("force: 10", "force: 0", 11, "fingers.max_normal_force", "> 0"),
    Bad("force: 10", "force: [10]", 11, "fingers.max_normal_force", "per finger: 2"),
    Bad("grid: [7, 7]", "grid: [0, 7]", 12, "fingers.placements.grid.0", ">= 1"),
    Bad("grid: [7, 7]", "grid: [7]", 12, "fingers.placements.grid", "at least 2"),
    Bad("grid: [7, 7]", "grid: [999, 999]", 12, "fingers.placements.grid", "coarser grid"),
    Bad("samples_per_arc: 3", "samples_per_arc: 0", 23, "cost.samples_per_arc", ">= 1"),
    Bad("cone_edges: 6", "cone_edges: 2", 22, "mechanics.cone_edges", ">= 3"),
    Bad("cone_edges: 6", "cone_edges: 65", 22, "mechanics.cone_edges", "<= 64"),
    Bad("directions: 76", "directions: 12", 22, "mechanics.directions", "must be 76"),
    Bad("z_min: 0.5", "z_min: -0.5", 22, "mechanics.z_min", ">= 0"),
    Bad("force: 10", "force: 10\n  soft: -1", 12, "fingers.soft", ">= 0"),
    Bad("force: 10", "force: 10\n  soft: [0.1]", 12, "fingers.soft", "one entry per finger: 2"),
    Bad("force: 10", "force: 10\n  soft: [0, x]", 12, "fingers.soft.1", "finite number"),
    Bad("force: 10", "force: 10\n  soft: 4", 12, "fingers.soft", "fingertip's radius, 1"),
    Bad("force: 10", "force: 10\n  soft: [1, 2]", 12, "fingers.soft.1", "radius, 1"),
    Bad("force: 10", "force: 10\n  softness: 1", 12, "fingers.softness", "'soft'"),
    Bad("samples_per_arc: 3", "samples_at: start", 23, "cost.samples_at", "'middles' or 'ends'"),
    Bad("samples_per_arc: 3", "samples_per_arc: 1, samples_at: ends", 23, "cost.samples_per_arc",
        "must be >= 2"),
    Bad("samples_per_arc: 3", "z_floor: 0", 23, "cost.z_floor", "> 0"),
    Bad("samples_per_arc: 3", "z_floor: 0.6", 23, "cost.z_floor", "mechanics.z_min, 0.5"),
    Bad("samples_per_arc: 3", "z_floor: 1e-20", 23, "cost.z_floor", ">= 1e-15"),
    Bad("z_min: 0.5", "margin: weak", 22, "mechanics.margin", "'nominal' or 'strong'"),
    Bad("z_min: 0.5", "backend: fast", 22, "mechanics.backend", "'kernel' or 'highs'"),
    Bad("regrasp: 100", "regrasp: -1", 23, "cost.regrasp", ">= 0"),
    Bad("segments: 30", "segments: 0", 21, "lattice.segments", ">= 1"),
    Bad("segments: 30", "segments: [30, 9]", 21, "lattice.segments", "per piece of motion.path: 1"),
    Bad("{segments: 30}", "{}", 21, "lattice.segments", "for example segments: 30"),
    # Words out of a list.
    Bad("scenario/1", "scenario/9", 1, "format", "'gm-ompl-scenario/1'"),
    Bad("faces: all", "faces: every", 12, "fingers.placements.faces", "'all'"),
    Bad("faces: all", "faces: []", 12, "fingers.placements.faces", "at least 1 entry"),
    Bad("faces: all", "faces: [+x, x]", 12, "fingers.placements.faces.1", "+x, -x, +y"),
    Bad("faces: all", "faces: [+x, +x]", 12, "fingers.placements.faces.1", "given twice"),
    Bad("towards: +x", "towards: +z", 20, "motion.path.0.tumble.towards", "'+x', '-x'"),
    Bad("lattice:", "expect: {status: sloved}\nlattice:", 21, "expect.status", "mean 'solved'"),
    # Angles.
    Bad("90 deg", "90", 20, "motion.path.0.tumble.angle", "with its unit"),
    Bad("90 deg", "90 degrees", 20, "motion.path.0.tumble.angle", "for example 90 deg"),
    Bad("90 deg", "-90 deg", 20, "motion.path.0.tumble.angle", "change towards"),
    Bad("90 deg", "0 deg", 20, "motion.path.0.tumble.angle", "> 0 deg"),
    # Shapes, walls, poses.
    Bad("{box: [5, 5, 10]}", "{}", 4, "object.shape", "exactly one of box, hull, mesh, pieces"),
    Bad("{box: [5", "{mesh: a.stl, box: [5", 4, "object.shape", "given: box and mesh"),
    Bad("{box: [5, 5, 10]}", "{mesh: a.stl}", 4, "object.shape.mesh", "no such file"),
    Bad("{box: [5, 5, 10]}", "{mesh: a.dxf}", 4, "object.shape.mesh", "ends in .stl, .obj, .ply"),
    Bad("{box: [5, 5, 10]}", "{mesh: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "
        "faces: [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4]]}}", 4, "object.shape.mesh",
        "names vertex 4"),
    Bad("{box: [5, 5, 10]}", "{pieces: [{box: {min: [0, 0, 0], max: [2, 2, 2]}}, "
        "{box: {min: [1, 1, 1], max: [3, 3, 3]}}]}", 4, "object.shape", "overlap"),
    Bad("{box: [5, 5, 10]}", "{pieces: [{}]}", 4, "object.shape.pieces.0", "one of box, hull"),
    Bad("10]}", "10], scale: 2}", 4, "object.shape.scale", "only for a mesh file"),
    Bad("{box: [5, 5, 10]}", "{hull: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}", 4, "object.shape.hull",
        "at least 4 entries, has 3"),
    Bad("{box: [5, 5, 10]}", "{hull: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]}", 4,
        "object.shape.hull", "one plane"),
    Bad("max: [-3,", "max: [-200,", 16, "environment.obstacles.wall.box.max.0", "> min"),
    Bad("max: [-3,", "max: [-2,", 18, "motion.start", "penetrates obstacle 'wall'"),
    Bad("[0, 0, 5]", "[0, 0, 4.9]", 18, "motion.start", "penetrates the floor"),
    Bad("90 deg", "120 deg", 19, "motion.path", "at the goal"),
    Bad("[0, 0, 5]", "[0, 0, 5], yaw: 30 deg", 20, "motion.path.0.tumble.towards", "right angles"),
    Bad("- tumble: {towards: +x, angle: 90 deg}", "- slide: {by: [0, 0, 0]}", 20,
        "motion.path.0.slide.by", "must not be zero"),
    Bad("- tumble: {", "- slide: {by: [1, 0, 0]}\n      tumble: {", 20, "motion.path.0",
        "exactly one of slide, tumble"),
    Bad("  path:", "  goal: {position: [1, 0, 5]}\n  path:", 19, "motion.goal", "leave goal out"),
    Bad("path:\n    - tumble: {towards: +x, angle: 90 deg}", "path: []", 19, "motion.path",
        "at least 1 entry"),
    # Mass.
    Bad("mass: 1", "mass: 1\n  centre_of_mass: [0, 0, 0]", 3, "object.inertia", "give both"),
    Bad("mass: 1", "mass: 1\n  centre_of_mass: [0, 0, 9]\n  inertia: [[1,0,0],[0,1,0],[0,0,1]]",
        4, "object.shape", "outside the shape"),
    Bad("mass: 1", "mass: 1\n  centre_of_mass: [0, 0, 0]\n  inertia: [[1,1,0],[0,1,0],[0,0,1]]",
        7, "object.inertia", "symmetric"),
    Bad("mass: 1", "mass: 1\n  centre_of_mass: [0, 0, 0]\n  inertia: [[1,2,0],[2,1,0],[0,0,1]]",
        7, "object.inertia", "positive definite"),
    Bad("mass: 1", "mass: 1\n  centre_of_mass: [0, 0, 0]\n  inertia: [[1,0,0],[0,1,0],[0,0,3]]",
        7, "object.inertia", "sum of the other two"),
    # Given placements.
    Bad("  max_normal_force: 10\n", HALF_STARTED + "[any]\n", 12, "fingers.start",
        "fingers.count is 2"),
    Bad("  max_normal_force: 10\n", HALF_STARTED + "[any, all]\n", 12, "fingers.start.1",
        "must be 'any'"),
    Bad("  max_normal_force: 10\n", HALF_STARTED + "[any, {face: up, cell: [0, 0]}]\n", 12,
        "fingers.start.1.face", "+x, -x"),
    Bad("  max_normal_force: 10\n", HALF_STARTED + "[any, {face: +x, cell: [0, 7]}]\n", 12,
        "fingers.start.1.cell.1", "last cell is 6"),
    Bad("  max_normal_force: 10\n",
        HALF_STARTED + "[{face: +x, cell: [0, 1]}, {face: +x, cell: [0, 1]}]\n", 12,
        "fingers.start.1", "same place as finger 0"),
    Bad("faces: all}", "faces: [+x]}\n  goal: [any, {face: -x, cell: [0, 0]}]", 13,
        "fingers.goal.1.face", "not among fingers.placements.faces (+x)"),
    # No placement left, and a placement that is not left.
    Bad("faces: all", "margin: 2.51", 12, "fingers.placements.margin", "must be at most 2.5"),
    Bad("faces: all", "faces: [+z, -z], margin: 9", 12, "fingers.placements.margin",
        "must be at most 2.5"),
    Bad("[7, 7], faces: all", "[2, 2], margin: 2", 12, "fingers.placements.margin",
        "with this grid and these faces it must be at most 1.25"),
    Bad("faces: all", "smallest_face: 0.3", 12, "fingers.placements.smallest_face",
        "largest has 0.2 of the surface"),
    Bad("faces: all}", "margin: 1}\n  start: [any, {face: +x, cell: [1, 0]}]", 13,
        "fingers.start.1", "the nearest cell with one is [1, 1]"),
    # YAML itself.
    Bad("mass: 1", "mass: !!float 1", 5, "object.mass", "tag"),
    Bad("mass: 1", "mass: !!python/object/apply:os.getpid []", 5, "object.mass", "tag"),
    Bad("mass: 1", "mass: *nobody", 5, "", "undefined alias"),
    Bad("mass: 1", "mass: [1", 6, "", "not valid YAML"),
    Bad("mass: 1", "mass: &a [*a]", 5, "object.mass.0", "alias refers to the value"),
    Bad("mass: 1", "mass: \t1: 2", 5, "", "not valid YAML"),
    Bad("cost:", "---\ncost:", 23, "", "another document"),
]  # fmt: skip

PLANAR_CASES = [
    Bad("x: [-2, 20]", "x: [20, -2]", 9, "motion.planar.x.1", "> the first"),
    Bad("[0, 0, 2.5]", "[0, 50, 2.5]", 10, "motion.start.position.1", "outside motion.planar.y"),
    Bad("[12, 6, 2.5]", "[12, 60, 2.5]", 11, "motion.goal.position.1", "outside motion.planar.y"),
    Bad("[12, 6, 2.5]", "[12, 6, 3]", 11, "motion.goal.position.2", "must equal the start's"),
    Bad("[-180 deg, 180 deg]", "[-1 rad, 1 rad]", 11, "motion.goal.yaw", "outside motion.planar"),
    Bad("[-180 deg, 180 deg]", "[-200 deg, 200 deg]", 9, "motion.planar.yaw", "full turn"),
    Bad("  goal: {position: [12, 6, 2.5], yaw: 90 deg}\n", "", 8, "motion.goal", "needs a goal"),
    Bad("{position: [12, 6, 2.5], yaw: 90 deg}", "{x: [13, 11], y: [5, 7]}", 11, "motion.goal.x",
        "must not exceed"),
    Bad("{position: [12, 6, 2.5], yaw: 90 deg}", "{x: [11, 33], y: [5, 7]}", 11, "motion.goal.x",
        "outside motion.planar.x"),
    Bad("{position: [12, 6, 2.5], yaw: 90 deg}", "{x: [11, 13], y: [5, 7], yaw: some}", 11,
        "motion.goal.yaw", "must be 'any'"),
    Bad("yaw: 5 deg", "yaw: 7 deg", 12, "lattice.steps.yaw", "must divide a full turn"),
    Bad("yaw: 5 deg", "yaw: -5 deg", 12, "lattice.steps.yaw", "> 0"),
    Bad("x: 0.5", "x: 1e-9", 12, "lattice.steps.x", "make it larger"),
    Bad("{steps: {x: 0.5, y: 0.5, yaw: 5 deg}}", "{segments: 30}", 12, "lattice.segments",
        "use steps"),
    Bad("lattice:", "  path: [{slide: {by: [1, 0, 0]}}]\nlattice:", 8, "motion",
        "exactly one of path, planar"),
    Bad("{count: 2", "{count: 5, placements: {grid: [50, 50]}", 12, "lattice.steps",
        "more than 2^62"),
]  # fmt: skip


def expect_line(error: ScenarioError, bad: Bad) -> None:
    """Some problem line has the file, the line, the key and the remedy."""
    start = re.compile(rf"\S*scenario\.yaml:{bad.line}:\d+: {re.escape(bad.key)}: " if bad.key
                       else rf"\S*scenario\.yaml:{bad.line}:\d+: ")  # fmt: skip
    matching = [p for p in error.problems if start.match(p) and bad.remedy in p]
    assert matching, "\n".join(error.problems)
    assert all("\n" not in problem for problem in error.problems)
    assert len(set(error.problems)) == len(error.problems)


@pytest.mark.parametrize("bad", PATH_CASES, ids=lambda bad: f"{bad.key}-{bad.new.strip()[:25]}")
def test_a_mistake_is_named_with_line_key_and_remedy(bad: Bad, load_changed: LoadChanged) -> None:
    """Each of these changes to a valid path scenario gives one line that says how to mend it."""
    with pytest.raises(ScenarioError) as caught:
        load_changed("path", bad.old, bad.new)
    expect_line(caught.value, bad)


@pytest.mark.parametrize("bad", PLANAR_CASES, ids=lambda bad: f"{bad.key}-{bad.new.strip()[:25]}")
def test_planar_mistakes_too(bad: Bad, load_changed: LoadChanged) -> None:
    """Likewise for planar scenarios."""
    with pytest.raises(ScenarioError) as caught:
        load_changed("planar", bad.old, bad.new)
    expect_line(caught.value, bad)


def test_the_unchanged_texts_are_valid(load_changed: LoadChanged) -> None:
    """The tables above change valid scenarios, so what they report comes from the change."""
    assert load_changed("path").name == "test/tumble"
    assert load_changed("planar").problem.lattice.size == 45 * 41 * 72


@pytest.mark.parametrize("bad", [b for b in PATH_CASES if len(b.new) < 40 and b.key], ids=str)
def test_one_mistake_gives_few_lines(bad: Bad, load_changed: LoadChanged) -> None:
    """A single mistake does not bury the user: a misspelt key is unknown and missing, no more."""
    with pytest.raises(ScenarioError) as caught:
        load_changed("path", bad.old, bad.new)
    assert len(caught.value.problems) <= 2


def test_all_mistakes_are_reported_at_once(load_changed: LoadChanged) -> None:
    """Mistakes in several sections, of kind and across keys, come together in file order."""
    with pytest.raises(ScenarioError) as caught:
        load_changed(
            "path",
            "mass: 1\nfriction: {environment: 0.5, finger: 0.7}",
            "mass: yes\nfriction: {enviroment: 0.5, finger: [1, 2, 3]}",
            "fingers.radius=[1]",
            "lattice.segments=[3, 4]",
        )
    text = str(caught.value)
    for part in ("object.mass", "friction.enviroment", "fingers.radius", "lattice.segments"):
        assert part in text


def test_a_hostile_name_stays_on_one_line(load_changed: LoadChanged) -> None:
    """Control characters in keys and values are escaped in messages."""
    with pytest.raises(ScenarioError) as caught:
        load_changed("path", "gravity: 9.8", '"a\\nb\\e[31m": "c\\nd"')
    assert len(str(caught.value).splitlines()) == 1
    assert "\x1b" not in str(caught.value)


def test_aliases_cannot_explode(load_changed: LoadChanged) -> None:
    """Nested aliases that would make billions of values are refused, quickly."""
    levels = "\n".join(
        f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 12)
    )  # fmt: skip
    with pytest.raises(ScenarioError, match="too large"):
        load_changed("path", "cost:", f"a0: &a0 [1, 1]\n{levels}\ncost:")


def test_deep_nesting_is_refused(load_changed: LoadChanged) -> None:
    """Brackets nested beyond Python's recursion are an input error, not a crash."""
    with pytest.raises(ScenarioError, match="nested too deeply"):
        load_changed("path", "mass: 1", "mass: " + "[" * 20_000)


def test_anchors_and_aliases_are_fine(load_changed: LoadChanged) -> None:
    """YAML's own means against repetition work."""
    scenario = load_changed(
        "path",
        "mechanics: {cone_edges: 6",
        "mechanics: {cone_edges: &six 6",
    )
    assert scenario.problem.mechanics.cone_edges == 6
    scenario = load_changed(
        "path", "radius: 1\n  max_normal_force: 10", "radius: &r [1, 2]\n  max_normal_force: *r"
    )
    assert scenario.problem.fingers.max_normal_force.tolist() == [1, 2]


@pytest.mark.parametrize("number", ["1e-3", "1E-3", "+1.0e-3", ".001", "0.001", "1.e-3"])
def test_numbers_in_every_usual_writing(number: str, load_changed: LoadChanged) -> None:
    """1e-3, which YAML 1.1 reads as text, is a number."""
    assert load_changed("path", "z_min: 0.5", f"z_min: {number}").problem.mechanics.z_min == 1e-3
