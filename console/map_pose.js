// Poses in a map in words and numbers: where a frame was taken, how well that is known, and where a landmark stands before the
// camera. Frames are those of REP 103: x forward, y left, z up; of optical frames z forward, x right, y down.

import {count, number} from "./parts.js";

const CHI2_95 = 5.991; // 95 % of a chi-squared distribution of two degrees of freedom
const SIGMAS_95 = 1.96;
const deg = (rad) => rad * 180 / Math.PI;

// Of a covariance of x, y (m) and heading (rad), row by row: half axes of the 95 % ellipse, how its long axis is turned from x
// counter-clockwise, and half the 95 % interval of the heading.
export function uncertainty([xx, xy, , , yy, , , , turned]) {
  const [mean, half] = [(xx + yy) / 2, Math.hypot((xx - yy) / 2, xy)];
  const axis = (variance) => Math.sqrt(CHI2_95 * Math.max(variance, 0));
  return {axes_m: [axis(mean + half), axis(mean - half)], turn_rad: Math.atan2(2 * xy, xx - yy) / 2,
    yaw_deg: Math.min(SIGMAS_95 * deg(Math.sqrt(Math.max(turned, 0))), 180)};
}

const metres = (value) => Math.abs(value) < 0.995 ? `${number(100 * value, 0)} cm` : `${number(value)} m`;

const METHODS = {
  exemplars: "the mean of the exemplars that agree",
  bearing: "the place of one exemplar, and the heading by the points in common with it",
  triangulation: "the points in common with several exemplars",
  flat_landmark: "a flat landmark of known size",
  track: "all frames of the track",
};

export const placeWords = ({map, x_m, y_m, yaw_deg}) => `${map}: x ${number(x_m)} m, y ${number(y_m)} m, heading ${number(yaw_deg, 1)}°`;

// How it was found and how well.
export function knownWords({covariance, method, support}) {
  const {axes_m: [major, minor], yaw_deg} = uncertainty(covariance);
  return `With 95 % within ± ${metres(major)} by ± ${metres(minor)}, heading ± ${number(yaw_deg, yaw_deg < 10 ? 1 : 0)}°; `
    + `by ${METHODS[method] ?? method}${support.length ? ` (${count(support.length, "exemplar")})` : ""}.`;
}

// The pose of an exemplar as a table or a caption has it.
export const poseNumbers = ({x_m, y_m, yaw_deg}) => `x ${number(x_m)}, y ${number(y_m)} m, ${number(yaw_deg, 1)}°`;

// Where a flat landmark stands before the camera: distance, bearing to the right, elevation, and how its normal is turned away from
// the line of sight. `translation_m` is in the optical frame; the landmark's x axis is its normal.
export function beforeCamera({translation_m: [x, y, z], quaternion: [qx, qy, qz, qw]}) {
  const distance_m = Math.hypot(x, y, z);
  const normal = [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qz * qw), 2 * (qx * qz - qy * qw)];
  const facing = -(normal[0] * x + normal[1] * y + normal[2] * z) / distance_m;
  return {distance_m, bearing_deg: deg(Math.atan2(x, z)), elevation_deg: deg(Math.atan2(-y, Math.hypot(x, z))),
    tilt_deg: deg(Math.acos(Math.min(Math.max(facing, -1), 1)))};
}

const side = (value, positive, negative) => Math.abs(value) < 0.05 ? null
  : `${number(Math.abs(value), 1)}° ${value > 0 ? positive : negative}`;

// The same in a sentence; null where the placement has no such pose.
export function landmarkWords({T_camera_landmark: pose, ambiguous, alternative}) {
  if (!pose) return null;
  const {distance_m, bearing_deg, elevation_deg, tilt_deg} = beforeCamera(pose);
  const where = [side(bearing_deg, "to the right", "to the left"), side(elevation_deg, "above", "below")].filter(Boolean).join(" and ");
  const other = ambiguous && alternative
    ? ` Ambiguous: it may as well be tilted by ${number(beforeCamera(alternative).tilt_deg, 0)}° the other way.` : "";
  return `${number(distance_m, 3)} m before the camera, ${where || "straight ahead"}, tilted by ${number(tilt_deg, 1)}° from facing it; `
    + `reprojection error ${number(pose.error_px)} px.${other}`;
}
