// The optics of two pictures: one lens before two sensors, or one sensor behind two apertures. All lengths in mm, blur in pixels.
//
// Lens law 1/f = 1/u + 1/v: u is the distance of a point, v that of its sharp image. Of a focal pair the near-focused picture's
// sensor stands at s_near, the far-focused one's at s_far = s_near − b, nearer to the lens; of an aperture pair both stand at
// one place. A point is blurred to a disc of the diameter D·|s − v|/v, with a telecentric stop D·|s − v|/f (docs/papers.md,
// B(1) to B(3)).

// The part of an aperture pair's largest blur that is left at the end of its working range next to the focus.
const LEAST_BLUR_SHARE = 0.2;

// Whether optics are of one focus and two apertures.
export const isAperturePair = (optics) => ["apertures_mm", "f_numbers", "plane_mm", "focus_mm", "range_end_mm"]
  .some((member) => optics[member] !== undefined);

// Whether optics are of three focus settings and more.
export const isStack = (optics) => optics.focuses_mm !== undefined || optics.planes_mm !== undefined;

// The blur that an unknown aperture is drawn with, in pixels.
const USUAL_BLUR = 5;

function checked(lengths) {
  for (const [name, value] of lengths) if (!(value > 0)) throw new Error(`The ${name} must be more than 0.`);
}

// The derived quantities of the optics; throws an Error that says why they are impossible. `blur(u)` is that of the
// near-focused and the far-focused picture, or of the wide-open and the stopped-down one.
export function lensOf(optics) {
  const {focal_length_mm: f, pixel_pitch_um: pitch, telecentric} = optics;
  checked([["focal length", f], ["pixel pitch", pitch]]);
  const imageDistance = (u) => f * u / (u - f); // B(1)
  const distanceOf = (v) => v > f ? f * v / (v - f) : Infinity; // B(1)
  const {apertures, sensors, ends} = isAperturePair(optics) ? aperturePair(optics, imageDistance)
    : focalPair(isStack(optics) ? endsOf(optics, imageDistance) : optics, imageDistance);
  const diameter = (k, v) => apertures[k] * Math.abs(sensors[k] - v) / (telecentric ? f : v) / (pitch / 1000); // B(2), B(3)
  const blur = (u) => [0, 1].map((k) => diameter(k, imageDistance(u)));
  const [nearFocus, farFocus] = ends.map(distanceOf);
  return {
    focalLength: f, aperture: apertures[0], nearPlane: sensors[0], farPlane: sensors[1], separation: sensors[0] - sensors[1],
    telecentric, nearFocus, farFocus, imageDistance, blur, range: farFocus - nearFocus,
    names: isAperturePair(optics) ? ["wide open", "stopped down"] : ["near-focused", "far-focused"],
    largestBlur: Math.max(...blur(farFocus), ...blur(nearFocus)),
    // The point of the scene that the near-focused picture shows at a pixel, `dx` and `dy` from where the axis meets the
    // picture: x right, y down, z along the axis. The chief ray runs through the middle of the stop.
    point(dx, dy, u) {
      const magnified = telecentric ? (u - f) / f : u / sensors[0];
      return [dx * pitch / 1000 * magnified, dy * pitch / 1000 * magnified, u];
    },
  };
}

// The first and the last picture of a stack as a focal pair.
function endsOf({planes_mm, focuses_mm, ...optics}, imageDistance) {
  const planes = planes_mm ?? focuses_mm.map(imageDistance);
  if (planes.length < 3) throw new Error("A stack has three focus distances and more, from near to far.");
  return {...optics, near_plane_mm: planes[0], plane_separation_mm: planes[0] - planes.at(-1)};
}

function focalPair(optics, imageDistance) {
  const {focal_length_mm: f, plane_separation_mm: separation} = optics;
  const aperture = optics.aperture === "unknown" ? USUAL_BLUR * optics.pixel_pitch_um / 1000 * f / separation
    : optics.aperture_mm ?? f / optics.f_number;
  checked([["aperture", aperture], ["separation", separation], ["near focus", optics.near_plane_mm ?? optics.near_focus_mm]]);
  if (optics.near_plane_mm === undefined && optics.near_focus_mm <= f) {
    throw new Error(`The near focus must be beyond the focal length of ${f} mm: a lens focuses nothing nearer.`);
  }
  const nearPlane = optics.near_plane_mm ?? imageDistance(optics.near_focus_mm);
  const farPlane = nearPlane - separation;
  if (farPlane <= f) {
    throw new Error("The far-focused sensor would be within the focal length and be focused on nothing: "
      + "take a smaller separation or a nearer focus.");
  }
  return {apertures: [aperture, aperture], sensors: [nearPlane, farPlane], ends: [nearPlane, farPlane]};
}

function aperturePair(optics, imageDistance) {
  const {focal_length_mm: f, range_end_mm: end} = optics;
  const apertures = (optics.apertures_mm ?? (optics.f_numbers ?? []).map((number) => f / number)).toSorted((a, b) => b - a);
  checked([["wider aperture", apertures[0]], ["narrower aperture", apertures[1]], ["focus", optics.plane_mm ?? optics.focus_mm],
    ["end of the range", end]]);
  if (end <= f || optics.plane_mm === undefined && optics.focus_mm <= f) {
    throw new Error(`The focus and the end of the range must be beyond the focal length of ${f} mm.`);
  }
  const sensor = optics.plane_mm ?? imageDistance(optics.focus_mm);
  const outer = imageDistance(end);
  const inner = sensor + LEAST_BLUR_SHARE * (outer - sensor);
  return {apertures, sensors: [sensor, sensor], ends: [Math.max(outer, inner), Math.min(outer, inner)]};
}
