"""Contains all the data models used in inputs/outputs"""

from .alias_body import AliasBody
from .alive import Alive
from .audit_body import AuditBody
from .audit_body_detail import AuditBodyDetail
from .auto_or_none_word import AutoOrNoneWord
from .auto_word import AutoWord
from .batch_body import BatchBody
from .batch_form import BatchForm
from .batch_item import BatchItem
from .belief_body import BeliefBody
from .calibration_body import CalibrationBody
from .candidate_body import CandidateBody
from .centring_body import CentringBody
from .colour_word import ColourWord
from .comparison_body import ComparisonBody
from .confusion_body import ConfusionBody
from .correspondence_body import CorrespondenceBody
from .counts_body import CountsBody
from .database_body import DatabaseBody
from .database_detail import DatabaseDetail
from .database_ready import DatabaseReady
from .decision_body import DecisionBody
from .depth_form import DepthForm
from .depth_map_body import DepthMapBody
from .depth_map_body_flags import DepthMapBodyFlags
from .depth_method_word import DepthMethodWord
from .depth_options_body import DepthOptionsBody
from .depth_span_body import DepthSpanBody
from .depth_timings import DepthTimings
from .dimension_rate_body import DimensionRateBody
from .distance_word import DistanceWord
from .exemplar_body import ExemplarBody
from .field_error import FieldError
from .filters_body import FiltersBody
from .frame_body import FrameBody
from .gap_body import GapBody
from .header_echo import HeaderEcho
from .held_out_body import HeldOutBody
from .image_body import ImageBody
from .image_form import ImageForm
from .images_form import ImagesForm
from .info import Info
from .inspect_pair_view import InspectPairView
from .inspection_body import InspectionBody
from .inspection_form import InspectionForm
from .inspection_timings import InspectionTimings
from .instance_body import InstanceBody
from .item_status import ItemStatus
from .job_body import JobBody
from .job_event import JobEvent
from .key_body import KeyBody
from .key_made import KeyMade
from .kind_word import KindWord
from .label_belief_body import LabelBeliefBody
from .landmark_evidence import LandmarkEvidence
from .landmark_options_body import LandmarkOptionsBody
from .landmark_recognition_body import LandmarkRecognitionBody
from .landmark_recognition_body_kind import LandmarkRecognitionBodyKind
from .landmark_report_body import LandmarkReportBody
from .landmark_stages import LandmarkStages
from .landmark_timings_body import LandmarkTimingsBody
from .landmark_tracked_frame_body import LandmarkTrackedFrameBody
from .limits_body import LimitsBody
from .list_jobs_state import ListJobsState
from .local_camera_body import LocalCameraBody
from .manifest_line import ManifestLine
from .mapping_body import MappingBody
from .mapping_kind_word import MappingKindWord
from .method_word import MethodWord
from .motion_word import MotionWord
from .new_alias import NewAlias
from .new_database import NewDatabase
from .new_key_body import NewKeyBody
from .new_track import NewTrack
from .new_training import NewTraining
from .noise_body import NoiseBody
from .normalise_word import NormaliseWord
from .object_evidence import ObjectEvidence
from .object_options_body import ObjectOptionsBody
from .object_recognition_body import ObjectRecognitionBody
from .object_recognition_body_kind import ObjectRecognitionBodyKind
from .object_stages import ObjectStages
from .object_timings_body import ObjectTimingsBody
from .object_tracked_frame_body import ObjectTrackedFrameBody
from .objects_report_body import ObjectsReportBody
from .one_object_body import OneObjectBody
from .operator_word import OperatorWord
from .optics_body import OpticsBody
from .page_alias_body import PageAliasBody
from .page_audit_body import PageAuditBody
from .page_calibration_body import PageCalibrationBody
from .page_database_body import PageDatabaseBody
from .page_exemplar_body import PageExemplarBody
from .page_job_body import PageJobBody
from .page_key_body import PageKeyBody
from .page_track_body import PageTrackBody
from .page_version_body import PageVersionBody
from .page_workcell_body import PageWorkcellBody
from .part_body import PartBody
from .per_label_word import PerLabelWord
from .photometric_body import PhotometricBody
from .placement_body import PlacementBody
from .plane_line import PlaneLine
from .point_body import PointBody
from .polarity_word import PolarityWord
from .pose_body import PoseBody
from .pose_errors_body import PoseErrorsBody
from .problem import Problem
from .process_body import ProcessBody
from .progress_body import ProgressBody
from .promote_word import PromoteWord
from .put_workcell import PutWorkcell
from .ready import Ready
from .ready_status import ReadyStatus
from .recognition_batch import RecognitionBatch
from .recognition_item_type_1 import RecognitionItemType1
from .region_body import RegionBody
from .registration_body import RegistrationBody
from .registration_form import RegistrationForm
from .reliability_bin_body import ReliabilityBinBody
from .reliability_body import ReliabilityBody
from .residual_body import ResidualBody
from .resize_word import ResizeWord
from .scope_word import ScopeWord
from .search_word import SearchWord
from .segmentation_body import SegmentationBody
from .segmentation_form import SegmentationForm
from .segmentation_options_body import SegmentationOptionsBody
from .segmentation_timings import SegmentationTimings
from .stages_word import StagesWord
from .state_word import StateWord
from .store_status import StoreStatus
from .sweep_form import SweepForm
from .sweep_options_body import SweepOptionsBody
from .table_body import TableBody
from .taper_word import TaperWord
from .threshold_word import ThresholdWord
from .track_body import TrackBody
from .track_detail import TrackDetail
from .training_timings import TrainingTimings
from .version_body import VersionBody
from .viewpoint_word import ViewpointWord
from .vote_body import VoteBody
from .workcell_body import WorkcellBody

__all__ = (
    "AliasBody",
    "Alive",
    "AuditBody",
    "AuditBodyDetail",
    "AutoOrNoneWord",
    "AutoWord",
    "BatchBody",
    "BatchForm",
    "BatchItem",
    "BeliefBody",
    "CalibrationBody",
    "CandidateBody",
    "CentringBody",
    "ColourWord",
    "ComparisonBody",
    "ConfusionBody",
    "CorrespondenceBody",
    "CountsBody",
    "DatabaseBody",
    "DatabaseDetail",
    "DatabaseReady",
    "DecisionBody",
    "DepthForm",
    "DepthMapBody",
    "DepthMapBodyFlags",
    "DepthMethodWord",
    "DepthOptionsBody",
    "DepthSpanBody",
    "DepthTimings",
    "DimensionRateBody",
    "DistanceWord",
    "ExemplarBody",
    "FieldError",
    "FiltersBody",
    "FrameBody",
    "GapBody",
    "HeaderEcho",
    "HeldOutBody",
    "ImageBody",
    "ImageForm",
    "ImagesForm",
    "Info",
    "InspectionBody",
    "InspectionForm",
    "InspectionTimings",
    "InspectPairView",
    "InstanceBody",
    "ItemStatus",
    "JobBody",
    "JobEvent",
    "KeyBody",
    "KeyMade",
    "KindWord",
    "LabelBeliefBody",
    "LandmarkEvidence",
    "LandmarkOptionsBody",
    "LandmarkRecognitionBody",
    "LandmarkRecognitionBodyKind",
    "LandmarkReportBody",
    "LandmarkStages",
    "LandmarkTimingsBody",
    "LandmarkTrackedFrameBody",
    "LimitsBody",
    "ListJobsState",
    "LocalCameraBody",
    "ManifestLine",
    "MappingBody",
    "MappingKindWord",
    "MethodWord",
    "MotionWord",
    "NewAlias",
    "NewDatabase",
    "NewKeyBody",
    "NewTrack",
    "NewTraining",
    "NoiseBody",
    "NormaliseWord",
    "ObjectEvidence",
    "ObjectOptionsBody",
    "ObjectRecognitionBody",
    "ObjectRecognitionBodyKind",
    "ObjectsReportBody",
    "ObjectStages",
    "ObjectTimingsBody",
    "ObjectTrackedFrameBody",
    "OneObjectBody",
    "OperatorWord",
    "OpticsBody",
    "PageAliasBody",
    "PageAuditBody",
    "PageCalibrationBody",
    "PageDatabaseBody",
    "PageExemplarBody",
    "PageJobBody",
    "PageKeyBody",
    "PageTrackBody",
    "PageVersionBody",
    "PageWorkcellBody",
    "PartBody",
    "PerLabelWord",
    "PhotometricBody",
    "PlacementBody",
    "PlaneLine",
    "PointBody",
    "PolarityWord",
    "PoseBody",
    "PoseErrorsBody",
    "Problem",
    "ProcessBody",
    "ProgressBody",
    "PromoteWord",
    "PutWorkcell",
    "Ready",
    "ReadyStatus",
    "RecognitionBatch",
    "RecognitionItemType1",
    "RegionBody",
    "RegistrationBody",
    "RegistrationForm",
    "ReliabilityBinBody",
    "ReliabilityBody",
    "ResidualBody",
    "ResizeWord",
    "ScopeWord",
    "SearchWord",
    "SegmentationBody",
    "SegmentationForm",
    "SegmentationOptionsBody",
    "SegmentationTimings",
    "StagesWord",
    "StateWord",
    "StoreStatus",
    "SweepForm",
    "SweepOptionsBody",
    "TableBody",
    "TaperWord",
    "ThresholdWord",
    "TrackBody",
    "TrackDetail",
    "TrainingTimings",
    "VersionBody",
    "ViewpointWord",
    "VoteBody",
    "WorkcellBody",
)
