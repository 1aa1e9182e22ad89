// The texts of warnings about an object: in a frame, or a part on a table.

export const OBJECT_WARNINGS = {
  touches_border: "The picture's border cuts it: what is missing may change the answer.",
  over_exposed: "Much of it is as bright as can be: its shading is lost. Shorten the exposure.",
  blank_picture: "It is black or flat: there is nothing to recognise.",
  gray_frame: "It is gray, and the exemplars are in colour: colours say nothing here.",
  beyond_threshold: "Nothing known is near enough: it is none of the database's objects, or was never shown like this.",
  close_second: "Another object is nearly as near: compare the candidates.",
  not_calibrated: "The version had too few views to know when to say “unknown”: it always names something, and gives no confidence.",
  resized: "It was scaled to the database's size.",
  no_region: "Nothing stands out from the background, so nothing could be cut out.",
  several_regions: "Several things stand out: the largest was taken.",
  beyond_horizon: "The mapping has no place for it: it lies beyond the horizon.",
  no_depth: "None of its pixels has a distance.",
};
