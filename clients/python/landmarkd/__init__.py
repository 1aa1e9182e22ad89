"""Client of landmarkd: where a robot is, and what it sees.

from landmarkd import Client

client = Client("http://127.0.0.1:8080")
answer = client.recognise("home", "frame.jpg")
print(answer.decision)
"""

from .artifact import Artifact
from .camera import Camera
from .client import Client
from .depth_map import DepthFlag, DepthMap
from .job import Job, JobFailed
from .optics import Optics
from .picture import Picture
from .pose import LandmarkPose, MapPose, Odometry, PlacePose
from .problem import FieldFault, Problem, Unreachable
from .recognition import Decision, Recognition
from .track import LabelBelief, Track, TrackedFrame

__all__ = [
    "Artifact",
    "Camera",
    "Client",
    "Decision",
    "DepthFlag",
    "DepthMap",
    "FieldFault",
    "Job",
    "JobFailed",
    "LabelBelief",
    "LandmarkPose",
    "MapPose",
    "Odometry",
    "Optics",
    "Picture",
    "PlacePose",
    "Problem",
    "Recognition",
    "Track",
    "TrackedFrame",
    "Unreachable",
]
