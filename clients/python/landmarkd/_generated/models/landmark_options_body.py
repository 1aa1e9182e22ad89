from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

from ..models.colour_word import ColourWord, check_colour_word
from ..models.method_word import MethodWord, check_method_word
from ..models.normalise_word import NormaliseWord, check_normalise_word
from ..models.operator_word import OperatorWord, check_operator_word
from ..models.per_label_word import PerLabelWord, check_per_label_word
from ..models.taper_word import TaperWord, check_taper_word
from ..models.viewpoint_word import ViewpointWord, check_viewpoint_word
from ..types import UNSET, Unset

T = TypeVar("T", bound="LandmarkOptionsBody")


@_attrs_define
class LandmarkOptionsBody:
    """Options of a database of kind `landmarks`. Defaults are those of `method` and `viewpoint`: a body that names another
    of these than the database has starts from that pair's defaults, and its other members are put over them.

    """

    method: MethodWord | None | Unset = UNSET
    viewpoint: None | Unset | ViewpointWord = UNSET
    operator: None | OperatorWord | Unset = UNSET
    symmetry_radius_px: int | None | Unset = UNSET
    """ Radius of the symmetry operator. """
    interest_points: int | None | Unset = UNSET
    """ Interest points an exemplar. """
    query_points: int | None | Unset = UNSET
    """ Interest points a query frame. """
    subwindow_radius_px: float | list[float] | None | Unset = UNSET
    rings: int | None | Unset = UNSET
    """ Rows of a polar sub-window. """
    sectors: int | None | Unset = UNSET
    """ Columns of a polar sub-window. """
    taper: None | TaperWord | Unset = UNSET
    normalise: None | NormaliseWord | Unset = UNSET
    colour: ColourWord | None | Unset = UNSET
    dimension: int | None | Unset = UNSET
    """ Dimension of the eigenspace. """
    neighbours: int | None | Unset = UNSET
    """ Nearest eigenpoints that each sub-window of a frame is matched with; the paper's method has one. """
    epsilon: float | None | Unset = UNSET
    """ ε of the vote 1/(D+ε). """
    per_label: None | PerLabelWord | Unset = UNSET
    position_prior_px: float | None | Unset = UNSET
    """ Upright: a window is believed to be seen within some such distance of where it was; null: anywhere. """

    def to_dict(self) -> dict[str, Any]:
        method: None | str | Unset
        if isinstance(self.method, Unset):
            method = UNSET
        elif isinstance(self.method, str):
            method = self.method
        else:
            method = self.method

        viewpoint: None | str | Unset
        if isinstance(self.viewpoint, Unset):
            viewpoint = UNSET
        elif isinstance(self.viewpoint, str):
            viewpoint = self.viewpoint
        else:
            viewpoint = self.viewpoint

        operator: None | str | Unset
        if isinstance(self.operator, Unset):
            operator = UNSET
        elif isinstance(self.operator, str):
            operator = self.operator
        else:
            operator = self.operator

        symmetry_radius_px: int | None | Unset
        if isinstance(self.symmetry_radius_px, Unset):
            symmetry_radius_px = UNSET
        else:
            symmetry_radius_px = self.symmetry_radius_px

        interest_points: int | None | Unset
        if isinstance(self.interest_points, Unset):
            interest_points = UNSET
        else:
            interest_points = self.interest_points

        query_points: int | None | Unset
        if isinstance(self.query_points, Unset):
            query_points = UNSET
        else:
            query_points = self.query_points

        subwindow_radius_px: float | list[float] | None | Unset
        if isinstance(self.subwindow_radius_px, Unset):
            subwindow_radius_px = UNSET
        elif isinstance(self.subwindow_radius_px, list):
            subwindow_radius_px = self.subwindow_radius_px

        else:
            subwindow_radius_px = self.subwindow_radius_px

        rings: int | None | Unset
        if isinstance(self.rings, Unset):
            rings = UNSET
        else:
            rings = self.rings

        sectors: int | None | Unset
        if isinstance(self.sectors, Unset):
            sectors = UNSET
        else:
            sectors = self.sectors

        taper: None | str | Unset
        if isinstance(self.taper, Unset):
            taper = UNSET
        elif isinstance(self.taper, str):
            taper = self.taper
        else:
            taper = self.taper

        normalise: None | str | Unset
        if isinstance(self.normalise, Unset):
            normalise = UNSET
        elif isinstance(self.normalise, str):
            normalise = self.normalise
        else:
            normalise = self.normalise

        colour: None | str | Unset
        if isinstance(self.colour, Unset):
            colour = UNSET
        elif isinstance(self.colour, str):
            colour = self.colour
        else:
            colour = self.colour

        dimension: int | None | Unset
        if isinstance(self.dimension, Unset):
            dimension = UNSET
        else:
            dimension = self.dimension

        neighbours: int | None | Unset
        if isinstance(self.neighbours, Unset):
            neighbours = UNSET
        else:
            neighbours = self.neighbours

        epsilon: float | None | Unset
        if isinstance(self.epsilon, Unset):
            epsilon = UNSET
        else:
            epsilon = self.epsilon

        per_label: None | str | Unset
        if isinstance(self.per_label, Unset):
            per_label = UNSET
        elif isinstance(self.per_label, str):
            per_label = self.per_label
        else:
            per_label = self.per_label

        position_prior_px: float | None | Unset
        if isinstance(self.position_prior_px, Unset):
            position_prior_px = UNSET
        else:
            position_prior_px = self.position_prior_px

        field_dict: dict[str, Any] = {}

        field_dict.update({})
        if method is not UNSET:
            field_dict["method"] = method
        if viewpoint is not UNSET:
            field_dict["viewpoint"] = viewpoint
        if operator is not UNSET:
            field_dict["operator"] = operator
        if symmetry_radius_px is not UNSET:
            field_dict["symmetry_radius_px"] = symmetry_radius_px
        if interest_points is not UNSET:
            field_dict["interest_points"] = interest_points
        if query_points is not UNSET:
            field_dict["query_points"] = query_points
        if subwindow_radius_px is not UNSET:
            field_dict["subwindow_radius_px"] = subwindow_radius_px
        if rings is not UNSET:
            field_dict["rings"] = rings
        if sectors is not UNSET:
            field_dict["sectors"] = sectors
        if taper is not UNSET:
            field_dict["taper"] = taper
        if normalise is not UNSET:
            field_dict["normalise"] = normalise
        if colour is not UNSET:
            field_dict["colour"] = colour
        if dimension is not UNSET:
            field_dict["dimension"] = dimension
        if neighbours is not UNSET:
            field_dict["neighbours"] = neighbours
        if epsilon is not UNSET:
            field_dict["epsilon"] = epsilon
        if per_label is not UNSET:
            field_dict["per_label"] = per_label
        if position_prior_px is not UNSET:
            field_dict["position_prior_px"] = position_prior_px

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)

        def _parse_method(data: object) -> MethodWord | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                method_type_0 = check_method_word(data)

                return method_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(MethodWord | None | Unset, data)

        method = _parse_method(d.pop("method", UNSET))

        def _parse_viewpoint(data: object) -> None | Unset | ViewpointWord:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                viewpoint_type_0 = check_viewpoint_word(data)

                return viewpoint_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | Unset | ViewpointWord, data)

        viewpoint = _parse_viewpoint(d.pop("viewpoint", UNSET))

        def _parse_operator(data: object) -> None | OperatorWord | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                operator_type_0 = check_operator_word(data)

                return operator_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | OperatorWord | Unset, data)

        operator = _parse_operator(d.pop("operator", UNSET))

        def _parse_symmetry_radius_px(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        symmetry_radius_px = _parse_symmetry_radius_px(d.pop("symmetry_radius_px", UNSET))

        def _parse_interest_points(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        interest_points = _parse_interest_points(d.pop("interest_points", UNSET))

        def _parse_query_points(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        query_points = _parse_query_points(d.pop("query_points", UNSET))

        def _parse_subwindow_radius_px(data: object) -> float | list[float] | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, list):
                    raise TypeError()
                componentsschemas_radii_body_type_1 = cast(list[float], data)

                return componentsschemas_radii_body_type_1
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(float | list[float] | None | Unset, data)

        subwindow_radius_px = _parse_subwindow_radius_px(d.pop("subwindow_radius_px", UNSET))

        def _parse_rings(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        rings = _parse_rings(d.pop("rings", UNSET))

        def _parse_sectors(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        sectors = _parse_sectors(d.pop("sectors", UNSET))

        def _parse_taper(data: object) -> None | TaperWord | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                taper_type_0 = check_taper_word(data)

                return taper_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | TaperWord | Unset, data)

        taper = _parse_taper(d.pop("taper", UNSET))

        def _parse_normalise(data: object) -> None | NormaliseWord | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                normalise_type_0 = check_normalise_word(data)

                return normalise_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | NormaliseWord | Unset, data)

        normalise = _parse_normalise(d.pop("normalise", UNSET))

        def _parse_colour(data: object) -> ColourWord | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                colour_type_0 = check_colour_word(data)

                return colour_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(ColourWord | None | Unset, data)

        colour = _parse_colour(d.pop("colour", UNSET))

        def _parse_dimension(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        dimension = _parse_dimension(d.pop("dimension", UNSET))

        def _parse_neighbours(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        neighbours = _parse_neighbours(d.pop("neighbours", UNSET))

        def _parse_epsilon(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        epsilon = _parse_epsilon(d.pop("epsilon", UNSET))

        def _parse_per_label(data: object) -> None | PerLabelWord | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                per_label_type_0 = check_per_label_word(data)

                return per_label_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | PerLabelWord | Unset, data)

        per_label = _parse_per_label(d.pop("per_label", UNSET))

        def _parse_position_prior_px(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        position_prior_px = _parse_position_prior_px(d.pop("position_prior_px", UNSET))

        landmark_options_body = cls(
            method=method,
            viewpoint=viewpoint,
            operator=operator,
            symmetry_radius_px=symmetry_radius_px,
            interest_points=interest_points,
            query_points=query_points,
            subwindow_radius_px=subwindow_radius_px,
            rings=rings,
            sectors=sectors,
            taper=taper,
            normalise=normalise,
            colour=colour,
            dimension=dimension,
            neighbours=neighbours,
            epsilon=epsilon,
            per_label=per_label,
            position_prior_px=position_prior_px,
        )

        return landmark_options_body
