"""Drawings of where the sensors are: in `simulate --plot`, and in the exported folder."""

import math
from xml.etree import ElementTree

import pytest
from joint_files import joint_text

import ccgen
from ccgen.export.arrangement import arrangement_context
from ccgen.export.package import render
from ccgen.figures.shape import shape_figure
from ccgen.figures.space import loads_figure
from ccgen.joint.load_files import parse_loads
from ccgen.resources import template
from ccgen.sensing.simulation import simulate

SVG = "{http://www.w3.org/2000/svg}"
ROUND = """
name = "round"
[geometry]
segments = 12
length = 0.24
range_of_motion = 3.0
elongation = [0.0, 0.05]
sections = [4, 8]
[sensors.transducer]
metres_per_count = 2e-6
""" + "".join(
    f'[[sensor]]\nname = "s{j}"\nspan = [{first}, {last}]\nangle = {angle}\nradius = {radius}\n'
    for j, (first, last, angle, radius) in enumerate(
        [(0, 11, 330, 0.03), (0, 5, 90, 0.03), (0, 11, 90, 0.03), (0, 11, 210, 0.015)]
    )
)


def test_segment_i_reaches_from_i_to_i_plus_1_in_every_picture():
    from matplotlib.figure import Figure

    from ccgen.figures.placement import placement_figure
    from ccgen.figures.sensors import draw_along
    from ccgen.placement.problem import Placement

    joint = ccgen.parse(joint_text())
    axes = Figure().subplots()
    draw_along(axes, joint)
    sensor = joint.sensors[0]
    (first,) = [line for line in axes.lines if line.get_ydata()[0] == 0]
    assert tuple(first.get_xdata()) == (sensor.start, sensor.end) == (0.0, 5.0)
    placed = placement_figure([Placement("heuristic", ((0, 4), (3, 8)), 0.1, 1)], 12).axes[0]
    assert [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in placed.patches] == [
        (0.0, 5.0), (3.0, 9.0),
    ]  # fmt: skip
    for drawn_axes in (axes, placed):
        ticks = drawn_axes.get_xticks()
        assert ticks.tolist() == [i + 0.5 for i in range(12)]
        labels = drawn_axes.xaxis.get_major_formatter().format_ticks(ticks)
        assert labels == [str(i) for i in range(12)]


def drawn(joint):
    text = template("sensors.svg.j2").render(name=joint.name, drawing=arrangement_context(joint))
    return ElementTree.fromstring(text)


def marks(tree):
    return [
        (float(c.get("cx")), float(c.get("cy")))
        for c in tree.iter(f"{SVG}circle")
        if c.get("r") == "5"
    ]


def bars(tree):
    return [
        tuple(float(line.get(key)) for key in ("x1", "x2"))
        for line in tree.iter(f"{SVG}line")
        if line.get("stroke-width") == "5"
    ]


def test_a_mark_stands_at_each_angle_and_radius():
    tree = drawn(ccgen.parse(ROUND))
    wanted = [(90, 1.0), (210, 0.5), (330, 1.0)]
    for (x, y), (degrees, share) in zip(marks(tree), wanted, strict=True):
        angle = math.radians(degrees)
        assert x == pytest.approx(120 + 78 * share * math.cos(angle), abs=0.06)
        assert y == pytest.approx(132 - 78 * share * math.sin(angle), abs=0.06)


def test_a_bar_along_the_joint_stands_for_each_sensor_in_the_order_of_their_angles():
    tree = drawn(ccgen.parse(ROUND))
    assert bars(tree) == [(360.0, 530.0), (360.0, 700.0), (360.0, 700.0), (360.0, 700.0)]
    texts = [text.text for text in tree.iter(f"{SVG}text")]
    labels = [text for text in texts if text.startswith("s") and text.endswith("°")]
    assert labels == ["s1, 90°", "s2, 90°", "s3, 210°", "s0, 330°"]
    borders = [line.get("x1") for line in tree.iter(f"{SVG}line") if line.get("stroke-dasharray")]
    assert borders == [f"{360 + 340 * 4 / 12:.1f}"]


def test_an_exported_folder_draws_its_sensors_and_its_readme_shows_them():
    joint = ccgen.parse(joint_text())
    _, files = render(ccgen.fit(joint))
    tree = ElementTree.fromstring(files["sensors.svg"])
    assert len(bars(tree)) == 6
    assert len(marks(tree)) == 2
    assert b"](sensors.svg)" in files["README.md"]


@pytest.mark.parametrize("text", [ROUND, joint_text()])
def test_drawings_of_a_shape_show_the_sensors_across_and_along(text):
    joint = ccgen.parse(text)
    loads = parse_loads("stiffness = 0.5\ntip_force = [1.0, 0.0, 0.0]", "l.toml", joint.geometry)
    for figure in (
        shape_figure(joint, simulate(joint, "uniform", 0.03)),
        loads_figure(joint, simulate(joint, loads=loads), loads),
    ):
        panels = {axes.get_title(): axes for axes in figure.axes}
        across, along = panels["Sensors, seen from the tip"], panels["Sensors along the joint"]
        assert len(along.get_yticklabels()) == len(joint.sensors)
        angles = {round(math.degrees(one.angle) % 360) for one in joint.sensors}
        assert {text.get_text() for text in across.texts} == {f"{angle}°" for angle in angles}


def test_strings_that_run_over_each_other_are_both_seen():
    from ccgen.figures.strings import strings_figure

    joint = ccgen.parse(ROUND)  # s1 runs within s2's span
    (axes,) = strings_figure(joint).axes
    strings = {line.get_label(): line for line in axes.lines if line.get_label()[0] == "s"}
    assert strings["s2"].get_linewidth() > 1.5 * strings["s1"].get_linewidth()
    assert strings["s2"].get_zorder() < strings["s1"].get_zorder()
    widths = {strings[name].get_linewidth() for name in ("s0", "s1", "s3")}
    assert widths == {strings["s1"].get_linewidth()}


def test_a_joint_that_bends_in_a_plane_has_room_for_its_numbers():
    from ccgen.figures.strings import strings_figure

    (axes,) = strings_figure(ccgen.parse(ROUND + '[estimator]\naxes = ["v"]\n')).axes
    low, high = axes.get_ylim()
    assert high - low > 0.25 * 0.24


def test_logarithmic_axes_have_numbers_without_powers():
    from matplotlib.figure import Figure

    from ccgen.figures.style import plain_numbers

    axes = Figure().subplots()
    axes.plot([1, 2], [0.002, 300.0])
    axes.set_yscale("log")
    plain_numbers(axes.yaxis)
    told = axes.yaxis.get_major_formatter().format_ticks([0.001, 0.01, 100.0, 1000.0])
    assert told == ["0.001", "0.01", "100", "1000"]


@pytest.mark.parametrize("name", ["s", "string_", "a_string_of_many"])
def test_the_legend_of_strings_stays_within_the_picture(name):
    from ccgen.figures.strings import strings_figure

    text = ROUND
    for i in range(9, -1, -1):
        text = text.replace(f'"s{i}"', f'"{name}{i}"')
    figure = strings_figure(ccgen.parse(text))
    figure.draw_without_rendering()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert box.x0 >= 0
    assert box.x1 <= figure.bbox.x1
