//! Overlays of the scene: errors, the reference, masks, and lookups (texels of maps, cascades,
//! lists of casters, and their times).

use super::{subject::Subject, truth::TruthSoFar};
use anyhow::Result;
use serde::{Deserialize, Serialize};
use umbrage::{
    Receivers, ShadowTechnique,
    cpu::Cpu,
    glam::UVec2,
    metrics::Pixel,
    picture::encode,
    plan::{
        catalogue::Catalogue,
        footprint::{MapPlace, MapPlaces},
    },
    techniques::{Exact, QueriedCell},
};

/// Colours of layers, sRGB: the palette of Okabe and Ito 2008, "Color universal design", which most
/// people can distinguish.
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
/// Opacity of images of lookups.
const OPACITY: u8 = 165;
const TRANSPARENT: [u8; 4] = [0; 4];

/// Overlays of the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Picture {
    #[default]
    Nothing,
    /// Pixels whose shadow is too dark or too light.
    Error,
    /// The result of rays.
    Truth,
    /// The result of the technique.
    Mask,
    /// Each texel of the map, alternately light and dark, in its layer's colour.
    Texels,
    /// Each layer of the map in a different colour: cascades, faces of a cube.
    Layers,
    /// The number of casters that a lookup tests.
    Lists,
    /// The time of lookups.
    Heat,
}

impl Picture {
    /// All kinds with their names. Clocks of browsers are too coarse for timing lookups.
    pub(crate) const ALL: &[(Self, &'static str)] = &[
        (Self::Nothing, "nothing"),
        (Self::Error, "error"),
        (Self::Truth, "truth"),
        (Self::Mask, "mask"),
        (Self::Texels, "texels"),
        (Self::Layers, "cascades"),
        (Self::Lists, "lists"),
        #[cfg(not(target_arch = "wasm32"))]
        (Self::Heat, "heat"),
    ];

    /// Reports whether the image shows lookups. It depends on the camera, the light and the
    /// settings, and not on the reference.
    pub(crate) const fn is_of_lookups(self) -> bool {
        matches!(self, Self::Texels | Self::Layers | Self::Lists | Self::Heat)
    }
}

/// Returns an image of errors, the reference or the mask as sRGB and opacity, a byte each. `None`
/// if there is nothing to show.
pub(crate) fn of_mask(kind: Picture, truth: &TruthSoFar, mask: Option<&[f32]>) -> Option<Vec<u8>> {
    if mask.is_none() && kind != Picture::Truth {
        return None;
    }
    let texel = |i: usize| match (kind, mask, truth.pixels[i]) {
        (_, _, Pixel::Empty | Pixel::Unlit) => TRANSPARENT,
        (Picture::Truth, _, _) => gray(truth.visibility[i]),
        (Picture::Mask, Some(mask), _) => gray(mask[i]),
        (Picture::Error, _, Pixel::Ambiguous) => TRANSPARENT,
        (Picture::Error, Some(mask), _) => error_color(mask[i] - truth.visibility[i]),
        _ => TRANSPARENT,
    };
    let is_of_mask = matches!(kind, Picture::Truth | Picture::Mask | Picture::Error);
    is_of_mask.then(|| (0..truth.pixels.len()).flat_map(texel).collect())
}

fn gray(value: f32) -> [u8; 4] {
    let level = encode(value);
    [level, level, level, 255]
}

/// Returns the colour of an error: red for too light (leaks), blue for too dark (acne), and
/// transparent for correct pixels.
fn error_color(off: f32) -> [u8; 4] {
    // Emphasise small errors.
    let strength = off.abs().min(1.0).sqrt();
    let opacity = (255.0 * strength).round() as u8;
    if off > 0.0 {
        [255, 40, 20, opacity]
    } else {
        [30, 90, 255, opacity]
    }
}

/// Returns an image of lookups as sRGB and opacity, a byte each. `None` if the technique has no
/// such lookups.
///
/// # Errors
/// Returns an error if the technique refuses the light.
pub(crate) fn of_lookups(
    kind: Picture,
    technique: &dyn ShadowTechnique,
    subject: &Subject,
    receivers: &Receivers,
) -> Result<Option<Vec<u8>>> {
    match kind {
        Picture::Lists => lists(technique, subject, receivers),
        Picture::Heat => heat(technique, subject, receivers).map(Some),
        _ => map_places(kind, technique, subject, receivers),
    }
}

fn map_places(
    kind: Picture,
    technique: &dyn ShadowTechnique,
    subject: &Subject,
    receivers: &Receivers,
) -> Result<Option<Vec<u8>>> {
    let recipe = technique.recipe(&subject.view())?;
    let catalogue = Catalogue::built_in();
    let Some(places) = MapPlaces::new(&recipe, &catalogue) else {
        return Ok(None);
    };
    let texel = |i: usize| {
        let place = receivers.receives[i].then(|| places.place_at(receivers.position(i)));
        place.flatten().map_or(TRANSPARENT, |place| match kind {
            Picture::Texels => texel_color(&place),
            _ => layer_color(&place),
        })
    };
    Ok(Some((0..receivers.len()).flat_map(texel).collect()))
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
    subject: &Subject,
    receivers: &Receivers,
) -> Result<Option<Vec<u8>>> {
    if technique.name() != Exact::default().name() {
        return Ok(None);
    }
    let view = subject.view().with_receivers(receivers);
    let cells = Exact::default().queried_cells(&view)?;
    Ok(Some(cells.iter().flat_map(length_color).collect()))
}

/// Block of pixels whose lookups are timed together. The time of fewer pixels would be close to
/// that of reading the clock.
const TIMED: UVec2 = UVec2::new(16, 8);
/// Number of timings of each block. The least one is used, since other programs only increase
/// times.
const RUNS: u32 = 3;

/// Times a technique's lookups on the CPU, block by block.
fn heat(
    technique: &dyn ShadowTechnique,
    subject: &Subject,
    receivers: &Receivers,
) -> Result<Vec<u8>> {
    let view = subject.view();
    let recipe = technique.recipe(&view)?;
    let view = view.with_receivers(receivers);
    let times = Cpu::new().lookup_times(&view, &recipe, TIMED, RUNS)?;
    let size = receivers.size;
    let columns = size.x.div_ceil(TIMED.x);
    let texel = |i: usize| {
        if !receivers.receives[i] {
            return TRANSPARENT;
        }
        let [x, y] = [i as u32 % size.x, i as u32 / size.x];
        let time = times[(y / TIMED.y * columns + x / TIMED.x) as usize];
        time.map_or(TRANSPARENT, heat_color)
    };
    Ok((0..receivers.len()).flat_map(texel).collect())
}

/// Nanoseconds per pixel at which [`heat_color`] is blue, white and red. The white one is the
/// geometric mean of the others.
pub(crate) const HEAT_NANOSECONDS: [f32; 3] = [4.0, 64.0, 1024.0];

fn heat_color(nanoseconds: f32) -> [u8; 4] {
    let [least, _, most] = HEAT_NANOSECONDS;
    blue_to_red((nanoseconds / least).log2() / (most / least).log2())
}

/// Numbers of casters at which [`length_color`] is white and red.
pub(crate) const LIST_LENGTHS: [u32; 2] = [7, 63];

/// Returns a colour from blue (none) over white to red, as in the panel's legend, or green if one
/// caster covers the whole cell.
fn length_color(cell: &Option<QueriedCell>) -> [u8; 4] {
    let Some(cell) = cell else {
        return TRANSPARENT;
    };
    if cell.is_covered {
        return [0, 130, 80, OPACITY];
    }
    let [_, most] = LIST_LENGTHS.map(|length| (length as f32 + 1.0).log2());
    blue_to_red((cell.length as f32 + 1.0).log2() / most)
}

/// Returns a colour from blue (0) over white (a half) to red (1).
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
    use umbrage::{Geometry, View};

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
            length_color(&Some(QueriedCell {
                number: 0,
                length,
                is_covered: false,
            }))
        };
        let [middle, most] = LIST_LENGTHS;
        assert_eq!((of_length(0), of_length(most)), (blue, red));
        assert_eq!(of_length(most + 1), red);
        assert!(is_white(of_length(middle)), "{:?}", of_length(middle));
        let covered = QueriedCell {
            number: 0,
            length: 1,
            is_covered: true,
        };
        let [r, g, b, _] = length_color(&Some(covered));
        assert!(g > r && g > b);
        assert_eq!(length_color(&None), TRANSPARENT);
    }

    /// A disc takes more taps than one comparison.
    #[test]
    fn more_lookups_are_hotter() {
        let entry = umbrage::scenes::find("cubes");
        let scene = (entry.expect("built in").build)();
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].with_size(UVec2::new(64, 48));
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

    #[test]
    fn errors_are_coloured_by_their_sign() {
        let truth = TruthSoFar::of_test();
        let mask = [1.0, 0.0, 0.5, 1.0];
        let picture = of_mask(Picture::Error, &truth, Some(&mask)).expect("there");
        assert_eq!(picture[..4], [255, 40, 20, 255]);
        assert_eq!(picture[4..8], [30, 90, 255, 255]);
        assert_eq!(picture[11], 0);
    }
}
