"""Client of landmarkd: where a robot is, and what it sees.

from landmarkd import Client

client = Client("http://127.0.0.1:8080")
answer = client.recognise("home", "frame.jpg")
print(answer.decision)
"""

from .artifact import Artifact
from .client import Client
from .depth_map import DepthFlag, DepthMap
from .job import Job, JobFailed
from .optics import Optics
from .picture import Picture
from .problem import FieldFault, Problem, Unreachable
from .recognition import Decision, Recognition
from .track import LabelBelief, Track, TrackedFrame

__all__ = [
    "Artifact",
    "Client",
    "Decision",
    "DepthFlag",
    "DepthMap",
    "FieldFault",
    "Job",
    "JobFailed",
    "LabelBelief",
    "Optics",
    "Picture",
    "Problem",
    "Recognition",
    "Track",
    "TrackedFrame",
    "Unreachable",
]
