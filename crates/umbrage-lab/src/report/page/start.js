"use strict";
header();
if (scenes.length) {
  if (data.groups.length) byId("first").append(firstScreen());
  byId("overview").append(tiles(), flatTable(), matrix());
  byId("scenes").append(...scenes.map(sceneSection));
} else {
  byId("first").append(el("p", { class: "notice" }, "No scene was compared."));
}
