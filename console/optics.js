// The optics of a focal pair: one lens, two sensors. All lengths in mm, blur in pixels.
//
// Lens law 1/f = 1/u + 1/v: u is the distance of a point, v that of its sharp image. The near-focused picture's sensor
// stands at s_near, the far-focused one's at s_far = s_near − b, nearer to the lens. A point is blurred to a disc of the
// diameter D·|s − v|/v, with a telecentric stop D·|s − v|/f (docs/papers.md, B(1) to B(3)).

// The derived quantities of the optics; throws an Error that says why they are impossible.
export function lensOf(optics) {
  const {focal_length_mm: f, plane_separation_mm: separation, pixel_pitch_um: pitch, telecentric} = optics;
  const aperture = optics.aperture_mm ?? f / optics.f_number;
  const imageDistance = (u) => f * u / (u - f); // B(1)
  const distanceOf = (v) => v > f ? f * v / (v - f) : Infinity; // B(1)
  for (const [name, value] of [["focal length", f], ["aperture", aperture], ["separation", separation], ["pixel pitch", pitch],
    ["near focus", optics.near_plane_mm ?? optics.near_focus_mm]]) {
    if (!(value > 0)) throw new Error(`The ${name} must be more than 0.`);
  }
  if (optics.near_plane_mm === undefined && optics.near_focus_mm <= f) {
    throw new Error(`The near focus must be beyond the focal length of ${f} mm: a lens focuses nothing nearer.`);
  }
  const nearPlane = optics.near_plane_mm ?? imageDistance(optics.near_focus_mm);
  const farPlane = nearPlane - separation;
  if (farPlane <= f) {
    throw new Error("The far-focused sensor would be within the focal length and be focused on nothing: "
      + "take a smaller separation or a nearer focus.");
  }
  const diameter = (sensor, v) => aperture * Math.abs(sensor - v) / (telecentric ? f : v) / (pitch / 1000); // B(2), B(3)
  const blur = (u) => [diameter(nearPlane, imageDistance(u)), diameter(farPlane, imageDistance(u))];
  const [nearFocus, farFocus] = [distanceOf(nearPlane), distanceOf(farPlane)];
  return {
    focalLength: f, aperture, nearPlane, farPlane, separation, telecentric, nearFocus, farFocus, imageDistance, blur,
    range: farFocus - nearFocus,
    largestBlur: Math.max(blur(farFocus)[0], blur(nearFocus)[1]),
    // The point of the scene that the near-focused picture shows at a pixel, `dx` and `dy` from where the axis meets the
    // picture: x right, y down, z along the axis. The chief ray runs through the middle of the stop.
    point(dx, dy, u) {
      const magnified = telecentric ? (u - f) / f : u / nearPlane;
      return [dx * pitch / 1000 * magnified, dy * pitch / 1000 * magnified, u];
    },
  };
}
