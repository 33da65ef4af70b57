"""The pictures show what they are said to show: looked at as pixels, in colour and in grey."""

import io

import numpy as np
import pytest
from lxml import etree
from matplotlib import image
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from flights.results import flight_pictures, picture_files
from flights.worlds import floor_plan
from simulation_tools.geometry import Pose
from simulation_tools.sdf import elements


def pixels(figure) -> np.ndarray:
    """Red, green and blue from 0 to 1, (rows, columns, 3), of its PNG file."""
    return image.imread(io.BytesIO(picture_files.png(figure)), format="png")[:, :, :3]


def grey(picture: np.ndarray) -> np.ndarray:
    return picture @ (0.299, 0.587, 0.114)


def square(x, y, size=2.0):
    half = size / 2
    corners = np.array(
        [(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)]
    )
    return floor_plan.Outline("box", corners, 0.0, 3.0)


def view(**changes):
    x = np.linspace(0.0, 20.0, 200)
    shown = {
        "title": "a flight",
        "outlines": [],
        "path": np.column_stack((x, np.zeros(200), np.linspace(0.5, 2.0, 200))),
        "value_label": "speed [m/s]",
        "start_xy": (0.0, 0.0),
        "goal_xy": (20.0, 0.0),
        "hits_xy": np.empty((0, 2)),
        "emergencies_xy": np.empty((0, 2)),
    }
    return flight_pictures.TopView(**{**shown, **changes})


def test_the_top_view_is_wide_enough_to_print_and_not_empty():
    picture = pixels(flight_pictures.top_view_figure(view()))
    assert picture.shape[1] > 1200
    assert 0.02 < (grey(picture) < 0.9).mean() < 0.5


def test_scales_are_equal():
    """A square obstacle is as wide as it is high."""
    empty = pixels(flight_pictures.top_view_figure(view()))
    picture = pixels(flight_pictures.top_view_figure(view(outlines=[square(10.0, 2.0)])))
    assert picture.shape[1] == empty.shape[1]
    solid = np.abs(picture - np.array([0x5B, 0x60, 0x66]) / 255).max(axis=2) < 0.02
    solid[int(0.7 * len(solid)) :] = False  # the legend shows one too
    rows, columns = np.nonzero(solid)
    assert np.ptp(rows) == pytest.approx(np.ptp(columns), abs=2)
    assert np.ptp(rows) > 50


def test_fast_and_slow_differ_in_grey():
    """The path from slow to fast gets lighter all along, also for who sees or prints no colour."""
    picture = pixels(flight_pictures.top_view_figure(view()))
    lightness = grey(picture)
    saturated = picture.max(axis=2) - picture.min(axis=2) > 0.15
    row = np.argmax(saturated[: int(0.75 * len(picture)), : int(0.8 * picture.shape[1])].sum(axis=1))
    along = lightness[row][saturated[row]]
    along = along[: int(0.9 * len(along))]  # without the colour bar
    tenths = [part.mean() for part in np.array_split(along, 10)]
    assert tenths[-1] - tenths[0] > 0.3
    assert np.diff(tenths).min() > 0.0


def test_lidar_hits_and_emergencies_are_drawn():
    hits = np.column_stack((np.linspace(2, 18, 500), np.full(500, 2.5)))
    plain = pixels(
        flight_pictures.top_view_figure(view(emergencies_xy=np.array([[10.0, 1.2]]), hits_xy=hits))
    )
    orange = (plain[:, :, 0] > 0.7) & (plain[:, :, 1] < 0.45) & (plain[:, :, 2] < 0.3)
    assert orange.sum() > 500


def test_the_flight_over_time_has_a_panel_for_each_quantity():
    t = np.linspace(0, 10, 100)
    panel = flight_pictures.TimeSeries("speed [m/s]", (("flown", np.column_stack((t, np.sin(t)))),))
    one, three = (pixels(flight_pictures.time_series_figure("a flight", (panel,) * n)) for n in (1, 3))
    assert three.shape[0] > 1.8 * one.shape[0]


def test_no_legend_lies_on_the_curves():
    t = np.linspace(0, 10, 100)
    curves = tuple((f"the curve of {n}", np.column_stack((t, np.sin(n * t)))) for n in (1, 2, 3))
    figure = flight_pictures.time_series_figure(
        "a flight", (flight_pictures.TimeSeries("speed", curves),) * 2
    )
    FigureCanvasAgg(figure).draw()
    for axes in figure.axes:
        legend = axes.get_legend().get_window_extent()
        assert not legend.overlaps(axes.get_window_extent())
        assert figure.bbox.x1 >= legend.x1  # nor is it cut off


def test_no_label_is_cut_off_at_the_border_of_a_file():
    """A plan and a square panel beside it, laid out by matplotlib, as the picture of the map error."""
    figure = Figure(figsize=(10.0, 5.0), layout="constrained")
    plan, square = figure.subplots(1, 2, gridspec_kw={"width_ratios": (2.2, 1.0)})
    plan.plot((-9.0, 9.0), (-7.0, 7.0), label="a line")
    plan.set(xlim=(-9.0, 9.0), ylim=(-7.0, 7.0), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    plan.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncol=3, frameon=False)
    square.set(xlabel="distance from the nearest true wall [m]", ylabel="occupied cells [%]")
    square.set_box_aspect(1.0)
    drawn = image.imread(io.BytesIO(picture_files.files("map_error", figure)["map_error.png"]))[:, :, :3]
    for border in (drawn[0], drawn[-1], drawn[:, 0], drawn[:, -1]):
        assert (border > 0.9).all()


def test_every_panel_shows_when_the_goal_was_reached():
    """What follows is the hover, in which the UAV flies back to the goal, over which it shot."""
    t = np.linspace(0, 10, 100)
    curve = (("flown", np.column_stack((t, 0.0 * t))),)
    panels = tuple(flight_pictures.TimeSeries(label, curve) for label in ("speed", "clearance"))
    figure = flight_pictures.time_series_figure("a flight", panels, ("goal reached", 8.0))
    for axes in figure.axes:
        assert [8.0, 8.0] in [list(line.get_xdata()) for line in axes.lines]
    assert "goal reached" in [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


def test_the_hull_of_a_square_with_points_inside():
    points = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0.5), (0.2, 0.9), (0.5, 0.0)])
    assert floor_plan.convex_hull(points).tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]


def area(corners):
    x, y = corners.T
    return 0.5 * abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1)))


def world_of(geometry, pose):
    collision = elements.Collision("shape", Pose.identity(), geometry)
    inertial = elements.Inertial(1.0, Pose.identity(), (1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
    link = elements.Link("link", Pose.from_xyz_rpy(0.0, 0.0, 0.5), inertial, collisions=(collision,))
    return elements.World("w", models=(elements.Model("thing", pose, True, (link,)),))


def test_outlines_have_the_areas_of_their_shapes():
    """From above a box on its side, a cylinder lying down and a ball cover what geometry says."""
    lying = Pose.from_xyz_rpy(3.0, 4.0, 1.0, np.pi / 2, 0.0, 0.3)
    for geometry, covered, height in (
        (elements.Box((2.0, 1.0, 3.0)), 2.0 * 3.0, 1.0),
        (elements.Cylinder(0.5, 3.0), 2 * 0.5 * 3.0, 1.0),
        (elements.Sphere(0.5), np.pi * 0.25, 1.0),
    ):
        (outline,) = floor_plan.outlines(world_of(geometry, lying))
        assert outline.name == "thing::link::shape"
        assert area(outline.outline_xy) == pytest.approx(covered, rel=0.01)
        assert outline.top_m - outline.bottom_m == pytest.approx(height, rel=0.01)


def test_an_outline_stands_where_the_poses_put_it():
    (outline,) = floor_plan.outlines(
        world_of(elements.Box((1.0, 1.0, 1.0)), Pose.from_xyz_rpy(3.0, 4.0, 1.0))
    )
    assert outline.outline_xy.mean(axis=0) == pytest.approx((3.0, 4.0))
    assert (outline.bottom_m, outline.top_m) == pytest.approx((1.0, 2.0))
    assert outline.blocks(1.5)
    assert not outline.blocks(2.5)


def test_the_ground_has_no_outline():
    assert floor_plan.outlines(world_of(elements.Plane(), Pose.identity())) == []


def test_a_figure_is_there_to_look_at_to_print_and_to_edit():
    """The same figure gives the same files; text stays text in the PDF, and lines stay lines in the SVG."""
    shown = picture_files.files("flight", flight_pictures.top_view_figure(view()))
    assert list(shown) == ["flight.png", "flight.pdf", "flight.svg"]
    assert shown["flight.png"].startswith(b"\x89PNG")
    assert shown["flight.pdf"].startswith(b"%PDF")
    assert b"/FontFile2" in shown["flight.pdf"]  # TrueType, as publishers want it, no bitmaps of letters
    drawing = etree.fromstring(shown["flight.svg"])
    assert len(drawing.findall(".//{*}path")) > 200  # the path flown has 199 segments
    assert picture_files.files("flight", flight_pictures.top_view_figure(view())) == shown
    # They have one crop, and it is the picture's own
    assert picture_files.png(flight_pictures.top_view_figure(view())) == shown["flight.png"]
