//! Pictures of where lookups go: texels of maps, cascades, lists of casters; and of how long they take.

use super::planned_view;
use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Aabb, Camera, Geometry, Light, Receivers, ShadowTechnique, View,
    cpu::Cpu,
    glam::UVec2,
    plan::{
        catalogue::Catalogue,
        footprint::{MapPlace, MapPlaces},
    },
    techniques::{AskedCell, Exact},
};

/// Colours of layers, sRGB: those of Okabe and Ito 2008, "Color universal design", which most people tell apart.
const LAYERS: [[u8; 3]; 8] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
    [204, 121, 167],
    [150, 150, 150],
];
/// Opacity of what is laid over.
const OPACITY: u8 = 165;
const NOTHING: [u8; 4] = [0; 4];

/// Which picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Places {
    /// Each texel, light and dark in turn, in its layer's colour.
    Texels,
    /// Each layer in a colour of its own.
    Layers,
    /// How many casters a lookup in lists asks.
    Lists,
    /// How long lookups take.
    Heat,
}

/// What a picture is of.
pub(crate) struct SeenFrom<'a> {
    pub camera: &'a Camera,
    pub light: &'a Light,
    pub geometry: &'a Geometry,
    /// The box around all casters for which a light set plans: a little larger than they are.
    pub casters: Aabb,
    pub receivers: &'a Receivers,
}

impl SeenFrom<'_> {
    /// Returns the view for which a light set plans.
    pub(crate) fn planned_view(&self) -> View<'_> {
        planned_view(self.camera, self.light, self.geometry, self.casters)
    }
}

/// Returns what makes a picture as sRGB and opacity, a byte each; none if the technique has nothing of that kind. It owns what it needs, so
/// that a thread can play it, and errors if the technique refuses the light.
pub(crate) fn job(
    kind: Places,
    technique: Arc<dyn ShadowTechnique>,
    seen: &SeenFrom<'_>,
    receivers: Arc<Receivers>,
) -> impl FnOnce() -> Result<Option<Vec<u8>>> + Send + 'static {
    let (camera, light, casters) = (*seen.camera, *seen.light, seen.casters);
    let geometry = seen.geometry.clone();
    move || {
        let seen = SeenFrom {
            camera: &camera,
            light: &light,
            geometry: &geometry,
            casters,
            receivers: &receivers,
        };
        picture(kind, &*technique, &seen)
    }
}

fn picture(
    kind: Places,
    technique: &dyn ShadowTechnique,
    seen: &SeenFrom<'_>,
) -> Result<Option<Vec<u8>>> {
    let view = seen.planned_view();
    if kind == Places::Lists {
        return lists(technique, &view, seen.receivers);
    }
    if kind == Places::Heat {
        return heat(technique, &view, seen.receivers).map(Some);
    }
    let recipe = technique.recipe(&view)?;
    let catalogue = Catalogue::built_in();
    let Some(places) = MapPlaces::new(&recipe, &catalogue) else {
        return Ok(None);
    };
    let texel = |i: usize| {
        if !seen.receivers.receives[i] {
            return NOTHING;
        }
        let place = places.at(seen.receivers.position(i));
        place.map_or(NOTHING, |place| match kind {
            Places::Texels => texel_color(&place),
            _ => layer_color(&place),
        })
    };
    Ok(Some((0..seen.receivers.len()).flat_map(texel).collect()))
}

fn layer_color(place: &MapPlace) -> [u8; 4] {
    let [r, g, b] = LAYERS[place.layer as usize % LAYERS.len()];
    [r, g, b, OPACITY]
}

fn texel_color(place: &MapPlace) -> [u8; 4] {
    let [column, row] = place.texel.to_array().map(|x| x as u32);
    let [r, g, b, a] = layer_color(place);
    if (column + row) % 2 == 0 {
        [r, g, b, a]
    } else {
        [r / 4, g / 4, b / 4, a]
    }
}

fn lists(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
    receivers: &Receivers,
) -> Result<Option<Vec<u8>>> {
    if technique.name() != Exact::default().name() {
        return Ok(None);
    }
    let with_receivers = (*view).with_receivers(receivers);
    let cells = Exact::default().asked_cells(&with_receivers)?;
    Ok(Some(cells.iter().flat_map(length_color).collect()))
}

/// Pixels of a block whose lookups are timed together: fewer take hardly longer than reading the clock does.
const TIMED: UVec2 = UVec2::new(16, 8);
/// How often each block is timed: the least counts, since whatever else runs only makes it longer.
const RUNS: u32 = 3;

/// Times a technique's lookups on the CPU, block by block.
fn heat(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
    receivers: &Receivers,
) -> Result<Vec<u8>> {
    let recipe = technique.recipe(view)?;
    let seen = (*view).with_receivers(receivers);
    let times = Cpu::new().lookup_times(&seen, &recipe, TIMED, RUNS)?;
    let size = receivers.size;
    let columns = size.x.div_ceil(TIMED.x);
    let texel = |i: usize| {
        if !receivers.receives[i] {
            return NOTHING;
        }
        let [x, y] = [i as u32 % size.x, i as u32 / size.x];
        let time = times[(y / TIMED.y * columns + x / TIMED.x) as usize];
        time.map_or(NOTHING, heat_color)
    };
    Ok((0..receivers.len()).flat_map(texel).collect())
}

/// Nanoseconds a pixel at which [`heat_color`] is blue, white and red: the white one is the mean of the others' logarithms.
pub(crate) const HEAT_NANOSECONDS: [f32; 3] = [4.0, 64.0, 1024.0];

fn heat_color(nanoseconds: f32) -> [u8; 4] {
    let [least, _, most] = HEAT_NANOSECONDS;
    blue_to_red((nanoseconds / least).log2() / (most / least).log2())
}

/// Casters at which [`length_color`] is white and red.
pub(crate) const LIST_LENGTHS: [u32; 2] = [7, 63];

/// From blue (none) over white to red, as the panel's legend says; green where one caster covers the whole cell.
fn length_color(cell: &Option<AskedCell>) -> [u8; 4] {
    let Some(cell) = cell else {
        return NOTHING;
    };
    if cell.is_covered {
        return [0, 130, 80, OPACITY];
    }
    let [_, most] = LIST_LENGTHS.map(|length| (length as f32 + 1.0).log2());
    blue_to_red((cell.length as f32 + 1.0).log2() / most)
}

/// From blue (0) over white (a half) to red (1).
fn blue_to_red(share: f32) -> [u8; 4] {
    let share = share.clamp(0.0, 1.0);
    let rising = (255.0 * share).round() as u8;
    let falling = 255 - rising;
    if share < 0.5 {
        [2 * rising.min(127), 2 * rising.min(127), 255, OPACITY]
    } else {
        [255, 2 * falling.min(127), 2 * falling.min(127), OPACITY]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_as_the_legend_says() {
        let is_white = |[r, g, b, _]: [u8; 4]| r.min(g).min(b) > 240;
        let [blue, red] = [[0, 0, 255, OPACITY], [255, 0, 0, OPACITY]];
        let [least, middle, most] = HEAT_NANOSECONDS;
        assert_eq!((heat_color(least), heat_color(most)), (blue, red));
        assert_eq!(
            (heat_color(0.5 * least), heat_color(2.0 * most)),
            (blue, red)
        );
        assert!(is_white(heat_color(middle)), "{:?}", heat_color(middle));
        let of_length = |length| {
            length_color(&Some(AskedCell {
                number: 0,
                length,
                is_covered: false,
            }))
        };
        let [middle, most] = LIST_LENGTHS;
        assert_eq!((of_length(0), of_length(most)), (blue, red));
        assert_eq!(of_length(most + 1), red);
        assert!(is_white(of_length(middle)), "{:?}", of_length(middle));
        let covered = AskedCell {
            number: 0,
            length: 1,
            is_covered: true,
        };
        let [r, g, b, _] = length_color(&Some(covered));
        assert!(g > r && g > b);
        assert_eq!(length_color(&None), NOTHING);
    }

    /// A disc takes more taps than one comparison.
    #[test]
    fn more_lookups_are_hotter() {
        let entry = umbrage::scenes::find("cubes");
        let scene = (entry.expect("built in").build)();
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].resized(UVec2::new(64, 48));
        let receivers = Cpu::new().receivers(&camera, &geometry).expect("seen");
        let view = View::new(&camera, &scene.lights[0], &geometry);
        let median = |name: &str| {
            let preset = (umbrage::techniques::find(name).expect(name).preset)();
            let recipe = preset.technique().recipe(&view).expect("a recipe");
            let seen = view.with_receivers(&receivers);
            let times = Cpu::new().lookup_times(&seen, &recipe, TIMED, RUNS);
            let mut times: Vec<f32> = times.expect("timed").into_iter().flatten().collect();
            assert!(!times.is_empty());
            times.sort_by(f32::total_cmp);
            times[times.len() / 2]
        };
        let (one, many) = (median("hard"), median("pcf_disc"));
        assert!(
            one > 0.0 && many > 1.5 * one,
            "hard {one} ns, disc {many} ns"
        );
    }
}
