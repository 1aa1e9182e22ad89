// Where a frame was taken, in words and on the map of the exemplars that say so.

import {h} from "./dom.js";
import {all} from "./api.js";
import {mapView} from "./map_view.js";
import {knownWords, placeWords} from "./map_pose.js";
import {marksOf} from "./database_map.js";

// A database's exemplars, each of which may have a pose; none for a key that may only recognise.
export const surveyed = (path, signal) => all(`${path}/exemplars`, {signal}).catch((error) => {
  if (error.status !== 403) throw error;
  return [];
});

// The answer's pose: null says that the exemplars that agree don't tell.
export function whereCard({pose}, {path, exemplar, signal}) {
  if (!pose) {
    return h("section", {class: "card", id: "try-where"}, h("h2", {}, "Where it was taken"),
      h("p", {}, "Not known: the exemplars that agree don't tell, or have no pose."));
  }
  const view = mapView({exemplar, signal});
  view.show({found: [pose]});
  surveyed(path, signal).then((list) => {
    view.show({marks: marksOf(list, pose.map), support: pose.support, found: [pose]});
    view.fit();
  }).catch(() => {});
  return h("section", {class: "card", id: "try-where"}, h("h2", {}, "Where it was taken"), ...placeLines(pose), view.node);
}

// A pose and how well it is known.
export const placeLines = (pose) => [
  h("p", {class: "answer"}, h("strong", {}, placeWords(pose)), pose.lost ? [" ", h("span", {class: "state failed"}, "lost")] : null),
  h("p", {class: "muted"}, knownWords(pose),
    pose.lost ? " The frames contradict each other, or tell of several places: don't drive by it." : "")];
