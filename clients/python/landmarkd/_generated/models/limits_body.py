from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="LimitsBody")


@_attrs_define
class LimitsBody:
    """What is refused."""

    max_body_bytes: int
    max_side_px: int
    max_pixels: int
    max_decode_bytes: int
    max_decode_bytes_total: int
    max_body_bytes_total: int
    max_batch_parts: int
    max_batch_bytes: int
    max_artifact_bytes: int
    max_tracks: int
    max_tracks_bytes: int
    track_idle_ms: int
    max_waiting: int
    threads: int
    request_timeout_ms: int
    max_connections: int
    header_timeout_ms: int
    body_timeout_ms: int
    idle_timeout_ms: int
    write_timeout_ms: int
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        max_body_bytes = self.max_body_bytes

        max_side_px = self.max_side_px

        max_pixels = self.max_pixels

        max_decode_bytes = self.max_decode_bytes

        max_decode_bytes_total = self.max_decode_bytes_total

        max_body_bytes_total = self.max_body_bytes_total

        max_batch_parts = self.max_batch_parts

        max_batch_bytes = self.max_batch_bytes

        max_artifact_bytes = self.max_artifact_bytes

        max_tracks = self.max_tracks

        max_tracks_bytes = self.max_tracks_bytes

        track_idle_ms = self.track_idle_ms

        max_waiting = self.max_waiting

        threads = self.threads

        request_timeout_ms = self.request_timeout_ms

        max_connections = self.max_connections

        header_timeout_ms = self.header_timeout_ms

        body_timeout_ms = self.body_timeout_ms

        idle_timeout_ms = self.idle_timeout_ms

        write_timeout_ms = self.write_timeout_ms

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "max_body_bytes": max_body_bytes,
                "max_side_px": max_side_px,
                "max_pixels": max_pixels,
                "max_decode_bytes": max_decode_bytes,
                "max_decode_bytes_total": max_decode_bytes_total,
                "max_body_bytes_total": max_body_bytes_total,
                "max_batch_parts": max_batch_parts,
                "max_batch_bytes": max_batch_bytes,
                "max_artifact_bytes": max_artifact_bytes,
                "max_tracks": max_tracks,
                "max_tracks_bytes": max_tracks_bytes,
                "track_idle_ms": track_idle_ms,
                "max_waiting": max_waiting,
                "threads": threads,
                "request_timeout_ms": request_timeout_ms,
                "max_connections": max_connections,
                "header_timeout_ms": header_timeout_ms,
                "body_timeout_ms": body_timeout_ms,
                "idle_timeout_ms": idle_timeout_ms,
                "write_timeout_ms": write_timeout_ms,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        max_body_bytes = d.pop("max_body_bytes")

        max_side_px = d.pop("max_side_px")

        max_pixels = d.pop("max_pixels")

        max_decode_bytes = d.pop("max_decode_bytes")

        max_decode_bytes_total = d.pop("max_decode_bytes_total")

        max_body_bytes_total = d.pop("max_body_bytes_total")

        max_batch_parts = d.pop("max_batch_parts")

        max_batch_bytes = d.pop("max_batch_bytes")

        max_artifact_bytes = d.pop("max_artifact_bytes")

        max_tracks = d.pop("max_tracks")

        max_tracks_bytes = d.pop("max_tracks_bytes")

        track_idle_ms = d.pop("track_idle_ms")

        max_waiting = d.pop("max_waiting")

        threads = d.pop("threads")

        request_timeout_ms = d.pop("request_timeout_ms")

        max_connections = d.pop("max_connections")

        header_timeout_ms = d.pop("header_timeout_ms")

        body_timeout_ms = d.pop("body_timeout_ms")

        idle_timeout_ms = d.pop("idle_timeout_ms")

        write_timeout_ms = d.pop("write_timeout_ms")

        limits_body = cls(
            max_body_bytes=max_body_bytes,
            max_side_px=max_side_px,
            max_pixels=max_pixels,
            max_decode_bytes=max_decode_bytes,
            max_decode_bytes_total=max_decode_bytes_total,
            max_body_bytes_total=max_body_bytes_total,
            max_batch_parts=max_batch_parts,
            max_batch_bytes=max_batch_bytes,
            max_artifact_bytes=max_artifact_bytes,
            max_tracks=max_tracks,
            max_tracks_bytes=max_tracks_bytes,
            track_idle_ms=track_idle_ms,
            max_waiting=max_waiting,
            threads=threads,
            request_timeout_ms=request_timeout_ms,
            max_connections=max_connections,
            header_timeout_ms=header_timeout_ms,
            body_timeout_ms=body_timeout_ms,
            idle_timeout_ms=idle_timeout_ms,
            write_timeout_ms=write_timeout_ms,
        )

        limits_body.additional_properties = d
        return limits_body

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
