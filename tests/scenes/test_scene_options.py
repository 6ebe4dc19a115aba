"""A file's units, axes, viewpoint and animation: as the options say, else noticed and said."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp.errors import InputError, SceneError
from hmdwarp.geometry import Pose
from hmdwarp.scenes import SceneOptions, load_scene

from .glb import IN_PLACE, SQUARE, Glb, boxes, cube

S = 1_000_000_000
FREE = SceneOptions()
ROOM = cube((-3, 0, -4), (3, 2.8, 2), inwards=True)


def vertices(scene) -> np.ndarray:
    """(n, 3) in the world."""
    return np.concatenate([mesh.positions for mesh in scene.meshes]) + scene.origin_m


def eye_in_file(scene, glb: Glb) -> np.ndarray:
    """Where the file has what stands at (0, 1.6, 0) here, by its own corners."""
    accessor = glb.header["accessors"][glb.primitive["attributes"]["POSITION"]]
    view = glb.header["bufferViews"][accessor["bufferView"]]
    corners = np.frombuffer(glb.binary, np.float32, view["byteLength"] // 4, view["byteOffset"]).reshape(-1, 3)
    here = vertices(scene)
    middle, middle_here = corners.mean(axis=0), here.mean(axis=0)
    turn, _ = Rotation.align_vectors(corners - middle, here - middle_here)
    return turn.apply((0, 1.6, 0) - middle_here) + middle


def test_scale_and_up_follow_the_options(tmp_path):
    glb = Glb()
    scaled = glb.load(tmp_path, options=SceneOptions(scale=0.001, viewpoint="0,1.6,0"))
    assert np.allclose(vertices(scaled), 0.001 * (SQUARE + (0, 1, -3)))
    turned = glb.load(tmp_path, options=SceneOptions(up="z", viewpoint="0,1.6,0"))
    x, y, z = (SQUARE + (0, 1, -3)).T
    assert np.allclose(vertices(turned), np.column_stack([x, z, -y]))
    assert np.allclose(turned.meshes[0].normals, (0, 1, 0))


def test_an_obj_is_scaled_and_turned_too(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1000 0 0\nv 0 2000 0\nf 1 2 3\n")
    scene = load_scene(tmp_path / "a.obj", SceneOptions(scale=0.001, up="z", viewpoint="0,1.6,0"))
    assert np.allclose(vertices(scene), [(0, 0, 0), (1, 0, 0), (0, 0, -2)])


def test_moving_parts_are_scaled_turned_and_placed_like_still_ones(tmp_path):
    """A body's vertices in the world at time 0 are those of the same file without its animation."""
    glb = Glb().animate("translation", (0, 1), ((0, 1, -3), (0, 1, -2)))
    options = SceneOptions(scale=0.5, up="z", viewpoint="1,2,3,30")
    moving = glb.load(tmp_path, options=options)
    still = glb.load(tmp_path, options=SceneOptions(scale=0.5, up="z", viewpoint="1,2,3,30", animation="none"))
    (mesh,), (body,) = moving.meshes, moving.bodies
    assert not still.bodies
    assert np.allclose(body.motion.state(0).pose.transform(mesh.positions), vertices(still), atol=1e-6)
    speed = body.motion.state(S // 2).velocity_m_s
    # 1 m/s along the file's z, which is up, at half the scale.
    assert np.allclose(speed, (0, 0.5, 0), atol=1e-6)


def test_a_skin_is_put_like_the_rest(tmp_path):
    glb = Glb().skin().animate("translation", (0, 1), ((0, 1, 0), (0, 2, 0)), node=2)
    scene = glb.load(tmp_path, options=SceneOptions(viewpoint="5,1.6,7"))
    (mesh,) = scene.meshes
    assert np.allclose(mesh.deformation.positions(0) + scene.origin_m, SQUARE - (5, 0, 7), atol=1e-6)
    assert np.allclose(mesh.positions + scene.origin_m, SQUARE - (5, 0, 7), atol=1e-6)


def test_the_viewer_stands_at_the_viewpoint_and_looks_where_it_says(tmp_path):
    """At (5, 2, -3), turned to the left by 90 degrees: the file's -x lies ahead."""
    scene = Glb().load(tmp_path, options=SceneOptions(viewpoint="5,2,-3,90"))
    assert scene.viewpoint.isclose(Pose((0, 1.6, 0)))
    # The square at x of -1..1, y of 0..2, z of -3: its corners are 4 to 6 m ahead.
    expected = [(0, y - 2 + 1.6, x - 5) for x, y, _ in SQUARE + (0, 1, -3)]
    assert np.allclose(vertices(scene), expected, atol=1e-6)
    assert scene.notes == ()


def with_cameras() -> Glb:
    glb = Glb()
    turn = [0, np.sin(np.pi / 4), 0, np.cos(np.pi / 4)]
    glb.header["cameras"] = [{"type": "perspective", "name": "wide"}, {"type": "perspective"}]
    glb.header["nodes"] += [{"name": "front", "camera": 0, "translation": [0, 1, 2]}]
    glb.header["nodes"] += [{"name": "side", "camera": 1, "translation": [5, 2, -3], "rotation": turn}]
    glb.header["scenes"][0]["nodes"] += [1, 2]
    return glb


@pytest.mark.parametrize("asked", ["side", "1"])
def test_a_camera_of_the_file_is_taken_by_name_or_number(tmp_path, asked):
    by_camera = with_cameras().load(tmp_path, options=SceneOptions(viewpoint=asked))
    by_hand = Glb().load(tmp_path, options=SceneOptions(viewpoint="5,2,-3,90"))
    assert np.allclose(vertices(by_camera), vertices(by_hand), atol=1e-6)


def test_unused_cameras_are_noted_and_unknown_ones_refused(tmp_path):
    glb = with_cameras()
    notes = glb.load(tmp_path, options=FREE).notes
    assert "thing.glb: has cameras: 'front', 'side'; --viewpoint NAME takes one" in notes
    with pytest.raises(InputError, match="the file has 0 'front', 1 'side'; expected one of them or X"):
        glb.load(tmp_path, options=SceneOptions(viewpoint="back"))


def two_animations() -> Glb:
    glb = Glb().animate("translation", (0, 1), ((0, 0, 0), (1, 0, 0)))
    second = glb.header.pop("animations")[0]
    glb.animate("translation", (0, 1), ((0, 0, 0), (0, 1, 0)))
    glb.header["animations"].insert(0, {**second, "name": "slide"})
    glb.header["animations"][1]["name"] = "rise"
    return glb


@pytest.mark.parametrize(
    ("asked", "speed"), [(None, (1, 0, 0)), ("rise", (0, 1, 0)), ("1", (0, 1, 0)), ("0", (1, 0, 0))]
)
def test_an_animation_is_chosen_by_name_or_number(tmp_path, asked, speed):
    options = SceneOptions(viewpoint="0,1.6,0", animation=asked)
    scene = two_animations().load(tmp_path, options=options)
    assert np.allclose(scene.bodies[0].motion.state(S // 2).velocity_m_s, speed)
    assert len(scene.notes) == (1 if asked is None else 0)


def test_an_unknown_animation_is_refused_with_the_known_ones(tmp_path):
    with pytest.raises(InputError, match="the file has 0 'slide', 1 'rise'; expected one of them or none"):
        two_animations().load(tmp_path, options=SceneOptions(animation="fall"))


def test_animations_that_move_different_things_play_together(tmp_path):
    glb = Glb().animate("translation", (0, 1), np.zeros((2, 3)))
    first = glb.header.pop("animations")[0]
    glb.animate("rotation", (0, 1), ((0, 0, 0, 1), (0, 1, 0, 0)))
    glb.header["animations"].insert(0, first)
    assert glb.load(tmp_path).notes == ()


@pytest.mark.parametrize("place", ["1,2", "1,2,nan", "1,2,3,4,5"])
def test_a_viewpoint_of_too_few_or_odd_numbers_is_refused(place):
    with pytest.raises(InputError, match=r"viewpoint '.*': expected X,Y,Z or X,Y,Z,YAW"):
        SceneOptions(viewpoint=place)


@pytest.mark.parametrize("option", [{"scale": 0.01}, {"up": "z"}, {"viewpoint": "0,1,2"}, {"animation": "none"}])
def test_scenes_of_the_library_take_no_options_of_files(option):
    (name,) = option
    flag = {"scale": "--scene-scale", "up": "--scene-up"}.get(name, f"--{name}")
    with pytest.raises(InputError, match=f"{flag} with scene 'planes': it is for scene files"):
        load_scene("planes", SceneOptions(**option))


def test_a_room_around_its_origin_keeps_its_numbers(tmp_path):
    scene = boxes(ROOM).load(tmp_path, options=FREE)
    assert scene.notes == ()
    assert np.allclose(vertices(scene)[0], (-3, 0, -4))
    low, high = scene.walk_bounds_m
    assert (low > (-3, 0, -4)).all() and (high < (3, 2.8, 2)).all()


def test_in_a_room_elsewhere_one_stands_on_its_floor(tmp_path):
    glb = boxes(cube((100, 50, 200), (108, 53, 206), inwards=True))
    scene = glb.load(tmp_path, options=FREE)
    eye = eye_in_file(scene, glb)
    assert eye[1] == pytest.approx(51.6, abs=1e-4)
    assert np.allclose(eye[[0, 2]], (104, 203), atol=1)
    assert "seen from 104,51.6,203 of the file, which is at (0, 1.6, 0) here" in scene.notes[0]


def is_in(eye: np.ndarray, low, high, by: float = 0.0) -> bool:
    return bool(((eye > np.array(low) - by) & (eye < np.array(high) + by)).all())


@pytest.mark.parametrize(
    "thing",
    [
        ((-1, 0, -2), (1, 2.8, 0)),  # a pillar in the middle, up to the ceiling
        ((-2.5, 0, -3.5), (2.5, 1.0, 1.5)),  # a platform nearly as large as the room
        ((-0.5, 1.2, -1.5), (0.5, 1.8, -0.5)),  # a lamp at the height of the eyes
    ],
    ids=["pillar", "platform", "lamp"],
)
def test_one_never_stands_inside_a_thing(tmp_path, thing):
    glb = boxes(ROOM, cube(*thing))
    scene = glb.load(tmp_path, options=FREE)
    eye = eye_in_file(scene, glb)
    assert is_in(eye, (-3, 0, -4), (3, 2.8, 2)) and not is_in(eye, *thing, by=0.3)


def test_a_solid_thing_of_a_rooms_size_is_looked_at_from_outside(tmp_path):
    """Nobody stands within it, nor on its roof: it fills 50 degrees, seen from its +z side."""
    glb = boxes(cube((-3, 0, -4), (3, 2.8, 2)))
    eye = eye_in_file(glb.load(tmp_path, options=FREE), glb)
    assert np.allclose(eye[:2], (0, 1.4), atol=1e-4)
    assert 2 * np.degrees(np.arctan(3 / (eye[2] - 2))) == pytest.approx(50)


def test_a_room_with_a_thick_floor_is_stood_on_not_in(tmp_path):
    """In millimetres a head 1.6 units up was inside the slab."""
    glb = boxes(cube((-4, -0.3, -4), (4, 0, 4)), cube((-4, 0, -4), (4, 3, -3.8)), cube((1, 0, 1), (2, 1, 2)))
    eye = eye_in_file(glb.load(tmp_path, options=FREE), glb)
    assert eye[1] == pytest.approx(1.6, abs=1e-4) and is_in(eye, (-4, 0, -4), (4, 3, 4))


def test_a_hollow_thing_is_not_stood_in(tmp_path):
    """It has a floor inside, and its top is seen from behind: as in a model of a board."""
    hollow = cube((-4, 0, -4), (4, 5, 4)), cube((-4, 0.2, -4), (4, 0.5, 4))
    glb = boxes(*hollow)
    assert eye_in_file(glb.load(tmp_path, options=FREE), glb)[2] > 4


def test_an_object_is_looked_at_from_its_front(tmp_path):
    glb = boxes(cube((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)))
    eye = eye_in_file(glb.load(tmp_path, options=FREE), glb)
    assert 2 * np.degrees(np.arctan(0.1 / (eye[2] - 0.1))) == pytest.approx(50)


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("0,1.6,0", "lies inside an object"),
        ("100,100,100", "lies far outside the scene, which is hardly seen from there"),
    ],
)
def test_a_viewpoint_from_which_nothing_is_seen_is_noted(tmp_path, place, said):
    scene = boxes(ROOM, cube((-1, 0, -1), (1, 2, 1))).load(tmp_path, options=SceneOptions(viewpoint=place))
    assert scene.notes == (f"thing.glb: the viewpoint {place} {said}",)


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (1000.0, "thing.glb: 6000 m across; if its unit is a millimetre, --scene-scale 0.001 makes it 6 m"),
        (
            100.0,
            "thing.glb: 600 m across; if its unit is a centimetre, --scene-scale 0.01 makes it 6 m"
            " or a millimetre, --scene-scale 0.001 makes it 0.6 m",
        ),
        (0.001, "thing.glb: 0.006 m across, and a head moves farther; --scene-scale 100 makes it 0.6 m"),
        (1 / 60, "thing.glb: 0.1 m across, and a head moves farther; --scene-scale 10 makes it 1 m"),
    ],
)
def test_units_other_than_metres_are_noticed_and_left_alone(tmp_path, factor, said):
    glb = boxes((ROOM[0] * np.float32(factor), ROOM[1]))
    scene = glb.load(tmp_path, options=IN_PLACE)
    assert said in scene.notes
    assert np.ptp(vertices(scene)[:, 0]) == pytest.approx(6 * factor, rel=1e-5)
    right = glb.load(tmp_path, options=SceneOptions(scale=1 / factor, viewpoint="0,1.6,0"))
    assert right.notes == () and np.ptp(vertices(right)[:, 0]) == pytest.approx(6, rel=1e-5)


def test_a_scene_beyond_float32_is_refused(tmp_path):
    """Squares of distances overflow float32 at 1e19 m, so that a drawing would fail in mid-run."""
    huge = boxes(cube((-1e29, -1e29, -1e29), (1e29, 1e29, 1e29)))
    with pytest.raises(SceneError, match="2e\\+29 m across; expected at most 1e\\+09 m.*--scene-scale"):
        huge.load(tmp_path, options=IN_PLACE)


def test_a_ground_below_the_z_axis_is_noticed_and_left_alone(tmp_path):
    """A table on a slab, both z up; the same with y up is not remarked on."""
    slab, table = ((-4, -4, -0.2), (4, 4, 0)), ((-1, -1, 0), (1, 1, 0.8))
    upright = boxes(cube(*slab), cube(*table))
    hint = "thing.glb: its ground lies below the z axis, not the y axis; if z is up, use --scene-up z"
    assert hint in upright.load(tmp_path, options=IN_PLACE).notes
    turned = upright.load(tmp_path, options=SceneOptions(up="z"))
    assert hint not in turned.notes
    assert np.ptp(vertices(turned)[:, 1]) == pytest.approx(1.0)
    assert hint not in boxes(ROOM, cube((-1, 0, -3), (1, 0.8, -1))).load(tmp_path, options=FREE).notes
