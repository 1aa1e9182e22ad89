from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

if TYPE_CHECKING:
    from ..models.counts_body import CountsBody
    from ..models.landmark_options_body import LandmarkOptionsBody
    from ..models.landmark_report_body import LandmarkReportBody
    from ..models.object_options_body import ObjectOptionsBody
    from ..models.objects_report_body import ObjectsReportBody


T = TypeVar("T", bound="VersionBody")


@_attrs_define
class VersionBody:
    """A trained version."""

    version: int
    digest: str
    """ Digest of the inputs: the same exemplars, options and algorithm give the same digest. """
    created_at: datetime.datetime
    revision: int
    """ Algorithm revision that trained it. """
    artifact_bytes: int
    """ Size of the artifact file. """
    options: LandmarkOptionsBody | ObjectOptionsBody
    """ Options of a database, by its kind. """
    counts: CountsBody
    """ What a version was trained from. """
    report: LandmarkReportBody | ObjectsReportBody
    """ What a training told of itself, by the kind of its database. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.landmark_options_body import LandmarkOptionsBody
        from ..models.landmark_report_body import LandmarkReportBody

        version = self.version

        digest = self.digest

        created_at = self.created_at.isoformat()

        revision = self.revision

        artifact_bytes = self.artifact_bytes

        options: dict[str, Any]
        if isinstance(self.options, LandmarkOptionsBody):
            options = self.options.to_dict()
        else:
            options = self.options.to_dict()

        counts = self.counts.to_dict()

        report: dict[str, Any]
        if isinstance(self.report, LandmarkReportBody):
            report = self.report.to_dict()
        else:
            report = self.report.to_dict()

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "version": version,
                "digest": digest,
                "created_at": created_at,
                "revision": revision,
                "artifact_bytes": artifact_bytes,
                "options": options,
                "counts": counts,
                "report": report,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.counts_body import CountsBody
        from ..models.landmark_options_body import LandmarkOptionsBody
        from ..models.landmark_report_body import LandmarkReportBody
        from ..models.object_options_body import ObjectOptionsBody
        from ..models.objects_report_body import ObjectsReportBody

        d = dict(src_dict)
        version = d.pop("version")

        digest = d.pop("digest")

        created_at = isoparse(d.pop("created_at"))

        revision = d.pop("revision")

        artifact_bytes = d.pop("artifact_bytes")

        def _parse_options(data: object) -> LandmarkOptionsBody | ObjectOptionsBody:
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                componentsschemas_options_body_type_0 = LandmarkOptionsBody.from_dict(data)

                return componentsschemas_options_body_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            if not isinstance(data, dict):
                raise TypeError()
            componentsschemas_options_body_type_1 = ObjectOptionsBody.from_dict(data)

            return componentsschemas_options_body_type_1

        options = _parse_options(d.pop("options"))

        counts = CountsBody.from_dict(d.pop("counts"))

        def _parse_report(data: object) -> LandmarkReportBody | ObjectsReportBody:
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                componentsschemas_report_body_type_0 = LandmarkReportBody.from_dict(data)

                return componentsschemas_report_body_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            if not isinstance(data, dict):
                raise TypeError()
            componentsschemas_report_body_type_1 = ObjectsReportBody.from_dict(data)

            return componentsschemas_report_body_type_1

        report = _parse_report(d.pop("report"))

        version_body = cls(
            version=version,
            digest=digest,
            created_at=created_at,
            revision=revision,
            artifact_bytes=artifact_bytes,
            options=options,
            counts=counts,
            report=report,
        )

        version_body.additional_properties = d
        return version_body

    @property
    def additional_keys(self) -> list[str]:
        return list(self.additional_properties.keys())

    def __getitem__(self, key: str) -> Any:
        return self.additional_properties[key]

    def __setitem__(self, key: str, value: Any) -> None:
        self.additional_properties[key] = value

    def __delitem__(self, key: str) -> None:
        del self.additional_properties[key]

    def __contains__(self, key: str) -> bool:
        return key in self.additional_properties
