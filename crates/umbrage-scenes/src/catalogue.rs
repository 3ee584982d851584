//! The list of built-in scenes.

use crate::builtin::{
    causes,
    closed::{area, card, everywhere, point_like, room, slits},
    content::{dancer, forest, leaf_cards, nave, night_room, street, valley},
    failures::{
        bleeding, corners, cut_outs, distant, facets, fine, lamps, nothing, penumbrae, projection,
        relief, rooms, scale, shells, spots, stairs, sunlit, volumes,
    },
    figure::figure,
    speed::{hall, statue, terrain, town},
    teapot::teapot_lamp,
    textbook::{TEXTBOOK_FIT, cubes},
    textbook_rooms::{ROOM_FIT, textbook_room, textbook_wall},
};
use crate::{ClosedForm, Failure, Kind, SceneEntry};
use umbrage_core::Scene;

/// Returns all built-in scenes.
pub fn all() -> &'static [SceneEntry] {
    ALL
}

/// Returns the built-in scene of this name.
pub fn find(name: &str) -> Option<&'static SceneEntry> {
    ALL.iter().find(|entry| entry.name == name)
}

type Build = fn() -> Scene;

const fn entry(name: &'static str, kind: Kind, build: Build, summary: &'static str) -> SceneEntry {
    SceneEntry {
        name,
        summary,
        kind,
        suite: true,
        quick: false,
        build,
        fit: None,
        max_left_out: None,
        closed_form: None,
    }
}

const fn closed_form_scene(
    name: &'static str,
    build: Build,
    samples: fn() -> ClosedForm,
    summary: &'static str,
) -> SceneEntry {
    SceneEntry {
        closed_form: Some(samples),
        ..entry(name, Kind::ClosedForm, build, summary)
    }
}

const fn cause(name: &'static str, build: Build, summary: &'static str) -> SceneEntry {
    entry(name, Kind::Cause, build, summary).by_name_only()
}

const fn failure(
    name: &'static str,
    failure: Failure,
    build: Build,
    summary: &'static str,
) -> SceneEntry {
    entry(name, Kind::Failure(failure), build, summary)
}

const fn speed(name: &'static str, build: Build, summary: &'static str) -> SceneEntry {
    entry(name, Kind::Speed, build, summary).by_name_only()
}

const fn content(name: &'static str, build: Build, summary: &'static str) -> SceneEntry {
    entry(name, Kind::Content, build, summary).by_name_only()
}

impl SceneEntry {
    /// Includes the scene in quick runs.
    const fn quick(self) -> Self {
        Self {
            quick: true,
            ..self
        }
    }

    /// Excludes the scene from the suite.
    const fn by_name_only(self) -> Self {
        Self {
            suite: false,
            ..self
        }
    }

    /// Allows comparisons to leave out more pixels as ambiguous than in other scenes.
    ///
    /// Pixels near an edge are ambiguous, and these scenes have edges in most pixels: leaves, wires
    /// and far boxes are smaller than a pixel. Far from the origin, positions are also rounded to
    /// millimetres or centimetres. Each limit is 1.3 to 1.6 times the greatest share of images of
    /// 80 x 60 to 320 x 240 pixels.
    const fn leaves_out(self, share: f64) -> Self {
        Self {
            max_left_out: Some(share),
            ..self
        }
    }

    const fn with_fit(self, fit: umbrage_core::Fit) -> Self {
        Self {
            fit: Some(fit),
            ..self
        }
    }
}

#[rustfmt::skip]
const ALL: &[SceneEntry] = &[
    entry("cubes", Kind::Textbook, cubes, "three cubes over a floor, as in every tutorial").with_fit(TEXTBOOK_FIT).quick(),
    entry("figure", Kind::Textbook, figure, "a person on a floor under a distant spot light"),
    entry("teapot-lamp", Kind::Textbook, teapot_lamp, "a pot with handle and spout under a square area light"),
    entry("textbook-room", Kind::Textbook, textbook_room, "five cubes around a point light in a room").with_fit(ROOM_FIT).by_name_only(),
    entry("textbook-wall", Kind::Textbook, textbook_wall, "a point light close to a normal-mapped brick wall").by_name_only(),

    closed_form_scene("c1-box-sun", point_like::box_sun, point_like::box_sun_samples, "a box in the sun: a hexagon"),
    closed_form_scene("c2-sphere-sun", point_like::sphere_sun, point_like::sphere_sun_samples, "a sphere in the sun: an ellipse"),
    closed_form_scene("c3-sphere-bulb", point_like::sphere_bulb, point_like::sphere_bulb_samples, "a sphere under a point light: an ellipse"),
    closed_form_scene("c3-room", room::room, room::room_samples, "spheres around a point light in a room: ellipses across a cube's seams").by_name_only(),
    closed_form_scene("c3b-sphere-level-bulb", point_like::sphere_level_bulb, point_like::sphere_level_bulb_samples, "a sphere at the height of a point light: an open hyperbola").by_name_only(),
    closed_form_scene("c4-edge-square", area::edge, area::edge_samples, "an edge under a square area light: a linear penumbra"),
    closed_form_scene("c4b-low-edge-square", area::low_edge, area::low_edge_samples, "the edge near the floor: a narrow penumbra").by_name_only(),
    closed_form_scene("c4c-edge-turned-square", area::turned_edge, area::turned_edge_samples, "an edge under a square area light turned by 45 degrees: parabolas").by_name_only(),
    closed_form_scene("c4d-edge-disc", area::disc_edge, area::disc_edge_samples, "an edge under a disc light").by_name_only(),
    closed_form_scene("c5-corner-square", area::corner, area::corner_samples, "a corner under a square area light: a product of ramps").by_name_only(),
    closed_form_scene("c6-slit", slits::slit, slits::slit_samples, "a slit 2 cm wide between sheets"),
    closed_form_scene("c6b-thick-slit", slits::thick_slit, slits::thick_slit_samples, "the slit between slabs 3 cm thick").by_name_only(),
    closed_form_scene("c6c-seam", slits::seam, slits::seam_samples, "two sheets with a common edge: no light between them").by_name_only(),
    closed_form_scene("c7-closed-room", everywhere::closed_room, everywhere::closed_room_samples, "a room with walls without thickness, the sun outside: no light inside"),
    closed_form_scene("c8-faceted-sphere", everywhere::faceted_sphere, everywhere::faceted_sphere_samples, "a single faceted sphere: each facet is lit or dark, no acne"),
    closed_form_scene("c9-bare-floor", everywhere::bare_floor, everywhere::bare_floor_samples, "a bare floor under a sun half a degree high: no acne"),
    closed_form_scene("c10-chequered-card", card::chequered_card, card::chequered_card_samples, "a card with square holes in the sun: a chequered shadow").by_name_only(),

    cause("cause-acne", causes::acne, "a bare floor: the only possible error is self-shadowing"),
    cause("cause-gap", causes::gap, "the foot of a thin plate: the only possible error is a gap"),
    cause("cause-leak", causes::leak, "a floor completely in shadow: the only possible error is a leak"),
    cause("cause-edge", causes::edge, "a hard edge: the only possible error is its position"),
    cause("cause-penumbra", causes::penumbra, "a soft edge: the only possible error is its width"),

    failure("low-sun-2", Failure::LowSun, sunlit::low_sun_2, "a row of spheres on 100 m of floor under a sun 2 degrees high").by_name_only(),
    failure("low-sun-5", Failure::LowSun, sunlit::low_sun_5, "a row of spheres on 100 m of floor under a sun 5 degrees high"),
    failure("low-sun-10", Failure::LowSun, sunlit::low_sun_10, "a row of spheres on 100 m of floor under a sun 10 degrees high").by_name_only(),
    failure("long-plane", Failure::DistantReceivers, distant::long_plane_sun, "balls along 300 m of floor in the sun").by_name_only(),
    failure("long-plane-lamp", Failure::DistantReceivers, distant::long_plane_lamp, "balls along 300 m of floor with a point light at one end").by_name_only(),
    failure("thin-plate", Failure::ThinContact, sunlit::thin_plate, "a plate 2 mm thick on a floor"),
    failure("sealed-room", Failure::SealedRoom, rooms::sealed_room, "a room with thin walls, the sun outside: no light inside"),
    failure("open-shells", Failure::OpenShell, shells::open_shells, "sheets, a box without lid and front, leaf cards"),
    failure("stacked-slices", Failure::ThinSlices, fine::stacked_slices, "six slices of 6 mm above each other").by_name_only(),
    failure("two-blockers", Failure::TwoBlockers, penumbrae::two_blockers, "a pole close to an area light over a wall far from it"),
    failure("hovering-feet", Failure::NearContact, fine::hovering_feet, "feet 1 cm above a floor").by_name_only(),
    failure("fence", Failure::FineDetail, fine::fence, "a fence of wires 12 mm thick").by_name_only(),
    failure("hills", Failure::Landscape, distant::hills, "hills with posts under a sun 14 degrees high").by_name_only(),
    failure("hills-1e5", Failure::FarFromOrigin, distant::hills_1e5, "the hills 100 km from the origin").by_name_only().leaves_out(0.08),
    failure("hills-1e6", Failure::FarFromOrigin, distant::hills_1e6, "the hills 1,000 km from the origin").by_name_only().leaves_out(0.20),
    failure("into-light", Failure::IntoLight, distant::into_light, "posts between the camera and the sun").by_name_only(),
    failure("lamp-in-room", Failure::CubeSeams, lamps::lamp_in_room, "a point light in a room, casters where a cube's faces meet").quick(),
    failure("glowing-lamp-in-room", Failure::CubeSeams, lamps::glowing_lamp_in_room, "the room lit by a ball light of 10 cm").by_name_only(),
    failure("rising-boxes", Failure::RisingHeights, penumbrae::rising_boxes, "a pole and boxes at increasing heights under a square area light").quick(),
    failure("rising-boxes-disc", Failure::RisingHeights, penumbrae::rising_boxes_disc, "the boxes at increasing heights under a disc light").by_name_only(),
    failure("canopy", Failure::Canopy, penumbrae::canopy, "leaves and a trunk under a large disc light"),
    failure("two-lights", Failure::TwoLights, lamps::two_lights, "one caster under two spot lights").by_name_only(),
    failure("bar-at-lamp", Failure::CasterAtLight, rooms::bar_at_lamp, "a thin bar 1 cm from a spot light"),
    failure("eye-in-umbra", Failure::EyeInUmbra, volumes::eye_in_umbra, "the camera in a shadow whose side cuts the near plane"),
    failure("eye-in-umbra-lamp", Failure::EyeInUmbra, volumes::eye_in_umbra_lamp, "the camera in the same shadow under a point light").by_name_only(),
    failure("broken-meshes", Failure::BrokenMesh, volumes::broken_meshes, "double faces, T-junctions, holes, fins in the sun"),
    failure("broken-meshes-lamp", Failure::BrokenMesh, volumes::broken_meshes_lamp, "the broken meshes around a point light").by_name_only(),
    failure("ten-thousand-boxes", Failure::ManyVolumes, volumes::ten_thousand_boxes, "10,000 boxes under a low sun").by_name_only().leaves_out(0.15),
    failure("stairs", Failure::Stairs, stairs::stairs, "stairs with a post through them in the sun"),
    failure("stairs-lamp", Failure::Stairs, stairs::stairs_lamp, "the stairs under a spot light with a slab above it").by_name_only(),
    failure("flat-receivers", Failure::Stairs, lamps::flat_receivers, "a floor and a wall, casters through them, below them and beyond the point light"),
    failure("displaced-wall", Failure::Relief, relief::displaced_wall, "a wall of displaced bricks in grazing sun"),
    failure("normal-mapped-wall", Failure::Relief, relief::normal_mapped_wall, "the bricks as a normal map alone").by_name_only(),
    failure("relief-without-depth-pass", Failure::Relief, relief::without_depth_pass, "the bricks receive and a flat wall casts: joints are lit").by_name_only(),
    failure("far-range", Failure::LongRange, sunlit::far_range, "balls and posts along 300 m under a sun 8 degrees high").by_name_only(),
    failure("sun-above", Failure::LightAlongUp, sunlit::sun_above, "a vertical sun"),
    failure("spot-above", Failure::LightAlongUp, sunlit::spot_above, "a vertical spot light").by_name_only(),
    failure("cubes-tiny", Failure::Scale, scale::tiny, "the cubes a thousand times smaller").with_fit(scale::TINY_FIT),
    failure("cubes-huge", Failure::Scale, scale::huge, "the cubes ten thousand times larger").with_fit(scale::HUGE_FIT),
    failure("no-casters", Failure::Nothing, nothing::no_casters, "no casters: everything is lit"),
    failure("no-receivers", Failure::Nothing, nothing::no_receivers, "nothing receives"),
    failure("only-sky", Failure::Nothing, nothing::only_sky, "the camera only sees the sky"),
    failure("tower-out-of-view", Failure::CasterOutOfView, sunlit::tower_out_of_view, "a tower outside the image casts its shadow into it"),
    failure("room-corner", Failure::RoomCorner, corners::room_corner, "the corner of a room with a stool and a point light").by_name_only(),
    failure("cone-rim", Failure::ConeRim, spots::cone_rim, "a spot light whose rim crosses posts and their shadows").by_name_only(),
    failure("small-lamp", Failure::SmallLight, spots::small_lamp, "an area light of 2 mm over a lattice").by_name_only(),
    failure("low-poly", Failure::LowPoly, facets::low_poly, "balls of 80 facets under a low sun").by_name_only(),
    failure("wire-fence", Failure::FineDetail, cut_outs::wire_fence, "a fence as one quad with alpha-tested wires").by_name_only().leaves_out(0.10),
    failure("foliage", Failure::CutOut, cut_outs::foliage, "trees of alpha-tested leaf cards, from 5 to 500 m away").by_name_only().leaves_out(0.35),
    failure("hills-endless", Failure::OtherProjection, projection::hills_endless, "the hills with reversed depth and without a far plane").by_name_only(),
    failure("two-plates", Failure::LightBleeding, bleeding::two_plates, "the shadow of a high plate across that of a low plate").by_name_only(),

    speed("hall", hall::hall, "an interior of 57,000 triangles"),
    speed("hall-soft", hall::hall_soft, "the interior under an area sun"),
    speed("statue", statue::statue, "a model of 69,000 triangles"),
    speed("town", town::town, "10,000 boxes along streets"),
    speed("town-soft", town::town_soft, "the town under an area sun"),
    speed("terrain", terrain::terrain, "hills of a million triangles"),

    content("nave", nave::nave, "a church from inside, with the sun in its windows"),
    content("nave-soft", nave::nave_soft, "the nave under an area sun"),
    content("street", street::street, "a street of a town under a low sun").quick(),
    content("street-soft", street::street_soft, "the street under a hazy sun"),
    content("forest", forest::forest, "a path through a wood in the sun").leaves_out(0.08),
    content("forest-soft", forest::forest_soft, "the forest under an area sun").leaves_out(0.08),
    content("valley", valley::valley, "2 km of land with poles, huts and firs under a low sun").leaves_out(0.12),
    content("valley-soft", valley::valley_soft, "the valley under an area sun").leaves_out(0.12),
    content("dancer", dancer::dancer, "a dancer on a stage under a spot light"),
    content("dancer-soft", dancer::dancer_soft, "the dancer under a large spot light"),
    content("leaf-cards", leaf_cards::leaf_cards, "a clearing behind a wire fence; leaves and wires are alpha-tested").leaves_out(0.12),
    content("leaf-cards-soft", leaf_cards::leaf_cards_soft, "the clearing under an area sun"),
    content("night-room", night_room::night_room, "a furnished room at night under three lights"),
    content("night-room-soft", night_room::night_room_soft, "the room under area lights"),
];

#[cfg(test)]
#[path = "catalogue_tests.rs"]
mod tests;
