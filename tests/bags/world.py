"""A corridor that the tests' robot drives along, and the bags that it records.

The robot drives in the direction of x at 1 m/s; its camera looks to the left, at a painted wall 2 m away. The bags are
written by the packages `rosbags` and `mcap-ros2-support`, which have nothing to do with landmarkd.
"""

import io
import random
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFilter

WIDTH, HEIGHT = 480, 360
FOCAL_PX = 300.0
WALL_M = 2.0
PX_A_METRE = FOCAL_PX / WALL_M
START_NS = 1_700_000_000_000_000_000
FRAMES_A_SECOND = 5


def wall(length_m, seed=1):
    """A wall of many shapes of many sizes and grays, by a seed."""
    draw_from = random.Random(seed)
    size = (int(length_m * PX_A_METRE) + WIDTH, HEIGHT)
    picture = Image.new("RGB", size, (128, 128, 128))
    canvas = ImageDraw.Draw(picture)
    for _ in range(size[0] * 2):
        x, y = draw_from.uniform(0, size[0]), draw_from.uniform(0, HEIGHT)
        radius = min(80, 4 * draw_from.random() ** -0.7)
        half_width, half_height = radius, radius * draw_from.uniform(0.4, 2.5)
        colour = tuple(draw_from.randrange(256) for _ in range(3))
        shape = canvas.rectangle if draw_from.random() < 0.6 else canvas.ellipse
        shape((x - half_width, y - half_height, x + half_width, y + half_height), fill=colour)
    return picture


@dataclass
class Moment:
    """Where the robot is at a time, and what its camera sees."""

    stamp_ns: int
    x_m: float
    pixels: np.ndarray  # height × width × 3, RGB


def drive(length_m, *, shift_m=0.0, blurred=(), wait=0, seed=1):
    """The moments of a drive, `shift_m` on from the start; the robot stands still for `wait` frames first."""
    scene = wall(length_m, seed)
    for n in range(wait + int((length_m - shift_m) * FRAMES_A_SECOND)):
        x_m = shift_m + max(0, n - wait) / FRAMES_A_SECOND
        left = round(x_m * PX_A_METRE)
        # the camera looks along y, so x grows to the right of its pictures
        picture = scene.crop((left, 0, left + WIDTH, HEIGHT))
        if n in blurred:
            picture = picture.filter(ImageFilter.BoxBlur(6))
        yield Moment(START_NS + n * 1_000_000_000 // FRAMES_A_SECOND, x_m, np.asarray(picture))


def encoded(pixels, kind):
    """The pixels as a JPEG or PNG."""
    into = io.BytesIO()
    Image.fromarray(pixels).save(into, kind, quality=90)
    return into.getvalue()


def raw(pixels, encoding):
    """The bytes of a sensor_msgs/Image, and the length of a row."""
    width = pixels.shape[1]
    if encoding == "bgr8":
        return pixels[:, :, ::-1].tobytes(), 3 * width
    if encoding == "mono8":
        return np.asarray(Image.fromarray(pixels).convert("L")).tobytes(), width
    if encoding == "bayer_rggb8":
        mosaic = pixels[:, :, 1].copy()
        mosaic[0::2, 0::2] = pixels[0::2, 0::2, 0]
        mosaic[1::2, 1::2] = pixels[1::2, 1::2, 2]
        return mosaic.tobytes(), width
    raise ValueError(encoding)


def split(stamp_ns):
    """Seconds and nanoseconds."""
    return divmod(stamp_ns, 1_000_000_000)


LEFT = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))  # a quarter of a turn about z
AHEAD = (0.0, 0.0, 0.0, 1.0)
# of a camera that looks to the left: its z is the base's y, its x the base's x, its y down
OPTICAL_LEFT = (-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))


def write_with_rosbags(path: Path, moments, *, distortion=(0.0,) * 5):
    """JPEGs, odometry that starts elsewhere, and /tf from the map: through the writer of `rosbags`."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    t = store.types

    def header(stamp_ns, frame):
        sec, nanosec = split(stamp_ns)
        return t["std_msgs/msg/Header"](t["builtin_interfaces/msg/Time"](sec, nanosec), frame)

    def transform(stamp_ns, parent, child, xyz, xyzw):
        return t["geometry_msgs/msg/TransformStamped"](
            header(stamp_ns, parent),
            child,
            t["geometry_msgs/msg/Transform"](
                t["geometry_msgs/msg/Vector3"](*xyz), t["geometry_msgs/msg/Quaternion"](*xyzw)
            ),
        )

    zeros = np.zeros(36)
    still = t["geometry_msgs/msg/TwistWithCovariance"](
        t["geometry_msgs/msg/Twist"](
            t["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0), t["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
        ),
        zeros,
    )
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:

        def topic(name, type_name):
            connection = writer.add_connection(name, type_name, typestore=store)
            return lambda stamp_ns, message: writer.write(connection, stamp_ns, store.serialize_cdr(message, type_name))

        image = topic("/camera/image_raw/compressed", "sensor_msgs/msg/CompressedImage")
        info = topic("/camera/camera_info", "sensor_msgs/msg/CameraInfo")
        odometry = topic("/odom", "nav_msgs/msg/Odometry")
        tf = topic("/tf", "tf2_msgs/msg/TFMessage")
        tf_static = topic("/tf_static", "tf2_msgs/msg/TFMessage")
        mount = transform(START_NS, "base_link", "camera_optical_frame", (0.1, 0.0, 0.5), OPTICAL_LEFT)
        tf_static(START_NS, t["tf2_msgs/msg/TFMessage"]([mount]))
        moments = list(moments)
        times = [moment.stamp_ns for moment in moments]
        for moment in moments:
            stamp_ns = moment.stamp_ns
            picture = t["sensor_msgs/msg/CompressedImage"](
                header(stamp_ns, "camera_optical_frame"),
                "jpeg",
                np.frombuffer(encoded(moment.pixels, "JPEG"), np.uint8),
            )
            image(stamp_ns + 30_000_000, picture)
            k = np.array([FOCAL_PX, 0, WIDTH / 2 - 0.5, 0, FOCAL_PX, HEIGHT / 2 - 0.5, 0, 0, 1])
            p = np.array([FOCAL_PX, 0, WIDTH / 2 - 0.5, 0, 0, FOCAL_PX, HEIGHT / 2 - 0.5, 0, 0, 0, 1, 0])
            region = t["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
            info(
                stamp_ns + 30_000_000,
                t["sensor_msgs/msg/CameraInfo"](
                    header(stamp_ns, "camera_optical_frame"),
                    HEIGHT,
                    WIDTH,
                    "plumb_bob",
                    np.array(distortion),
                    k,
                    np.eye(3).ravel(),
                    p,
                    0,
                    0,
                    region,
                ),
            )
        # between the pictures: their poses are interpolated; in the odometry's frame, 5 m from the map's
        for stamp_ns in range(times[0] - 50_000_000, times[-1] + 150_000_000, 100_000_000):
            x_m = float(np.interp(stamp_ns, times, [moment.x_m for moment in moments]))
            pose = t["geometry_msgs/msg/Pose"](
                t["geometry_msgs/msg/Point"](x_m - 5.0, 0.0, 0.0), t["geometry_msgs/msg/Quaternion"](*AHEAD)
            )
            odometry(
                stamp_ns,
                t["nav_msgs/msg/Odometry"](
                    header(stamp_ns, "odom"),
                    "base_link",
                    t["geometry_msgs/msg/PoseWithCovariance"](pose, zeros),
                    still,
                ),
            )
            tf(
                stamp_ns,
                t["tf2_msgs/msg/TFMessage"]([transform(stamp_ns, "map", "odom", (5.0, 0.0, 0.0), AHEAD)]),
            )


POINT = "float64 x\nfloat64 y\nfloat64 z\n"
HEADER = "builtin_interfaces/Time stamp\nstring frame_id\n"
TIME = "int32 sec\nuint32 nanosec\n"
RULE = "=" * 80 + "\nMSG: "
IMAGE = (
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
    "uint8 is_bigendian\nuint32 step\nuint8[] data\n"
    f"{RULE}std_msgs/Header\n{HEADER}{RULE}builtin_interfaces/Time\n{TIME}"
)
POSE = (
    "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n"
    f"{RULE}std_msgs/Header\n{HEADER}{RULE}builtin_interfaces/Time\n{TIME}"
    f"{RULE}geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n"
    f"{RULE}geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"
    f"{RULE}geometry_msgs/Point\n{POINT}{RULE}geometry_msgs/Quaternion\n{POINT}float64 w\n"
)


def write_with_mcap(path: Path, moments, *, encoding, shuffle_poses=False):
    """Raw images and poses in the map: through the writer of `mcap-ros2-support`."""
    from mcap_ros2.writer import Writer

    def header(stamp_ns, frame):
        sec, nanosec = split(stamp_ns)
        return {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": frame}

    with path.open("wb") as file, Writer(file) as writer:
        images = writer.register_msgdef("sensor_msgs/msg/Image", IMAGE)
        poses = writer.register_msgdef("geometry_msgs/msg/PoseWithCovarianceStamped", POSE)
        moments = list(moments)
        order = list(moments)
        if shuffle_poses:
            random.Random(3).shuffle(order)
        for moment in order:
            x, y, z, w = AHEAD
            pose = {
                "position": {"x": moment.x_m, "y": 0.0, "z": 0.0},
                "orientation": {"x": x, "y": y, "z": z, "w": w},
            }
            message = {
                "header": header(moment.stamp_ns, "map"),
                "pose": {"pose": pose, "covariance": [0.0] * 36},
            }
            writer.write_message("/amcl_pose", poses, message, moment.stamp_ns, moment.stamp_ns)
        for moment in moments:
            data, step = raw(moment.pixels, encoding)
            message = {
                "header": header(moment.stamp_ns, "camera"),
                "height": HEIGHT,
                "width": WIDTH,
                "encoding": encoding,
                "is_bigendian": 0,
                "step": step,
                "data": data,
            }
            writer.write_message("/camera/image_raw", images, message, moment.stamp_ns, moment.stamp_ns)
