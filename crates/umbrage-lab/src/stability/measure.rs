//! Measures of the cases, their units, and their limits to pass and to fail.

use super::{
    case_truth::CaseTruth,
    measures::{
        band::{self, Band},
        cube_seams, edge,
        gap::{self, Contact},
        open,
        penumbra::{self, ShadowPlaces},
    },
    verdict::VerdictLimits,
};
use glam::Vec3;
use umbrage_core::{
    Aabb, Instance, Light,
    metrics::{Errors, Pixel},
};

/// A measure of one case: smaller is better, and truth has 0.
///
/// Some measures see only one kind of error, false shadow or false light. [`Measure::opposite`]
/// then measures the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// [`open::acne`].
    Acne,
    /// The worst bin of [`open::acne_by_distance`].
    AcneByDistance,
    /// [`open::leak`].
    Leak,
    /// [`open::lost_shadow`].
    LostShadow,
    /// [`open::wrong`].
    Wrong,
    /// RMSE over all pixels that count.
    Rmse,
    /// [`Contact::gap`].
    Gap(Contact),
    /// [`Contact::leak`] within this reach, metres.
    ContactLeak(Contact, f32),
    /// [`gap::leak_around`] these places within this reach, metres.
    LeakAround(&'static [Vec3], f32),
    /// [`edge::displacement`].
    EdgeDisplacement,
    /// [`cube_seams::wrong_within`] two texels of a cube's seams.
    Seams,
    /// [`cascade_seams::excess`](super::measures::cascade_seams::excess).
    CascadeSeams,
    /// [`band::wrong_within`] a part of the image.
    WrongNear(Band),
    /// [`penumbra::rmse`].
    PenumbraRmse,
    /// [`penumbra::ShadowPlaces::widths`]: mean deviation of the ratio from 1 over all casters.
    PenumbraWidth,
    /// Percentage of pixels that the mask darkens at all, except those facing away from the light.
    AllLit,
    /// Difference of the RMSE from that of the same technique on the scene of this name, which is
    /// the same scene at scale 1.
    ScaleDrift(&'static str),
    /// Fragments that casts draw, in images of 1280 x 720. Those of casts from the camera grow with
    /// the number of pixels.
    Fill,
    /// [`shimmer::shimmer`](super::measures::shimmer) at points within
    /// [`OPEN_TEXELS`](super::OPEN_TEXELS) of an edge.
    Shimmer,
    /// [`shimmer::change_error`](super::measures::shimmer) at such points, if the light moves.
    ChangeError,
}

/// Limits for percentages of wrong pixels: one in a thousand is invisible, one in a hundred is a
/// visible patch.
const SHARE: VerdictLimits = VerdictLimits::new(0.1, 1.0);
/// Smallest visible step of visibility: one level of an 8-bit image.
const STEP: f64 = 1.0 / 255.0;
/// Greatest distance of counted pixels from a seam, texels.
const SEAM_TEXELS: f32 = 2.0;
/// Number of rays per pixel whose noise passes in penumbrae; they give 17 gray levels.
const RAYS: u32 = 16;
/// Least visible percentage of all pixels.
const SMALL_SHARE: f64 = 0.1;
/// Least visible percentage in a narrow band: of some hundred pixels, one percent is a few pixels.
const BAND_SHARE: f64 = 1.0;
/// Greatest invisible displacement, pixels.
const HALF_PIXEL: f64 = 0.5;
/// Greatest height difference of pixels that still show the floor, metres.
const LEVEL: f32 = 0.01;

impl Measure {
    /// Returns a short name of the measure.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Acne => "acne",
            Self::AcneByDistance => "acne in the worst bin of distance",
            Self::Leak => "leak",
            Self::LostShadow => "lost shadow",
            Self::Wrong => "wrong away from edges",
            Self::Rmse => "RMSE",
            Self::Gap(_) => "gap",
            Self::ContactLeak(..) => "leak at the contact",
            Self::LeakAround(..) => "leak around the contacts",
            Self::EdgeDisplacement => "edge displacement",
            Self::Seams => "wrong on seams",
            Self::CascadeSeams => "jumps between cascades",
            Self::WrongNear(Band::Creases { .. }) => "wrong along creases",
            Self::WrongNear(Band::ConeRim { .. }) => "wrong along the rim",
            Self::PenumbraRmse => "RMSE in penumbrae",
            Self::PenumbraWidth => "penumbra width error",
            Self::AllLit => "darkened though nothing shadows",
            Self::ScaleDrift(_) => "RMSE beyond scale 1's",
            Self::Fill => "fill",
            Self::Shimmer => "shimmer",
            Self::ChangeError => "change unlike truth's",
        }
    }

    /// Returns the measure that a fix of this failure may worsen: lost shadow for acne, acne for
    /// leaks and gaps, and RMSE where no shadow at all would be perfect. `None` for measures that
    /// count false shadow and false light alike.
    pub fn opposite(&self) -> Option<Self> {
        match self {
            Self::Acne | Self::AcneByDistance => Some(Self::LostShadow),
            Self::Leak
            | Self::LostShadow
            | Self::Gap(_)
            | Self::ContactLeak(..)
            | Self::LeakAround(..) => Some(Self::Acne),
            Self::ScaleDrift(_)
            | Self::Fill
            | Self::Shimmer
            | Self::ChangeError
            | Self::CascadeSeams => Some(Self::Rmse),
            Self::Wrong
            | Self::Rmse
            | Self::EdgeDisplacement
            | Self::Seams
            | Self::WrongNear(_)
            | Self::PenumbraRmse
            | Self::PenumbraWidth
            | Self::AllLit => None,
        }
    }

    /// Returns the figure's unit; empty for plain numbers.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Gap(_) => "mm",
            Self::EdgeDisplacement => "px",
            Self::Fill => "M fragments",
            Self::Rmse
            | Self::PenumbraRmse
            | Self::ScaleDrift(_)
            | Self::Shimmer
            | Self::ChangeError => "",
            _ => "%",
        }
    }

    /// Returns the reason for the limits.
    pub fn reason(&self) -> &'static str {
        match self {
            Self::Acne | Self::AcneByDistance | Self::Leak | Self::Wrong => {
                "away from edges nothing may be wrong: one pixel in a thousand is invisible, one in a hundred is a patch; both in addition to twice a perfect map's figure"
            }
            Self::Rmse => {
                "twice the figure of a perfect map of this size, plus 1/255; fails at four times that, or near the figure of no shadow"
            }
            Self::Gap(_) => {
                "twice the figure of a perfect map of this size, plus a row of pixels; fails at four times that, or near the figure of no shadow"
            }
            Self::LostShadow => {
                "twice the figure of a perfect map of this size, plus one dark pixel in a hundred; fails at four times that, or near the figure of no shadow"
            }
            Self::ContactLeak(..) | Self::LeakAround(..) | Self::WrongNear(_) => {
                "twice the figure of a perfect map of this size, plus one pixel in a hundred there; fails at four times that, or near the figure of no shadow"
            }
            Self::EdgeDisplacement => {
                "twice the figure of a perfect map of this size, plus half a pixel; fails at four times that, or near the figure of no shadow"
            }
            Self::Seams => {
                "twice the figure of a perfect map of this size, plus one pixel in a thousand; fails at four times that, or near the figure of no shadow"
            }
            Self::CascadeSeams => {
                "of a hundred pixel pairs across a seam, one jump is invisible; four are a visible line"
            }
            Self::PenumbraRmse => {
                "passes up to the noise of 16 independent rays per pixel; fails above half the error of a light without extent"
            }
            Self::PenumbraWidth => {
                "passes within a quarter of the true width; fails if off by more than half of it"
            }
            Self::AllLit => "nothing may be darkened: any darkened pixel fails",
            Self::ScaleDrift(_) => "passes up to 1/255; fails above four times that",
            Self::Fill => "passes up to four fragments per pixel; fails above sixteen",
            Self::Shimmer => {
                "passes up to a mean change of 1/255 per frame; fails above four times that"
            }
            Self::ChangeError => {
                "in blocks of 16 x 16 pixels, passes up to a mean change of 1/255 per frame more or less than truth's; fails above four times that, or near the figure of no movement"
            }
        }
    }

    /// Returns the figure of a mask, in the measure's unit; 0 for measures that a single mask
    /// doesn't determine: fill, shimmer, change, and seams between cascades.
    pub fn figure(&self, case_truth: &CaseTruth, mask: &[f32]) -> f64 {
        let truth = &case_truth.truth.visibility;
        let receivers = &case_truth.truth.receivers;
        let open = &case_truth.open;
        let counts = |i: usize| case_truth.counts(i);
        match *self {
            Self::Acne => open::acne(mask, truth, open),
            Self::AcneByDistance => worst(open::acne_by_distance(
                mask,
                truth,
                open,
                &receivers.distance,
            )),
            Self::Leak => open::leak(mask, truth, open),
            Self::LostShadow => open::lost_shadow(mask, truth, counts),
            Self::Wrong => open::wrong(mask, truth, open),
            Self::Rmse | Self::ScaleDrift(_) => rmse(case_truth, mask),
            Self::Gap(contact) => 1e3 * contact.gap(mask, truth, receivers, counts),
            Self::ContactLeak(contact, reach) => {
                contact.leak(mask, truth, receivers, reach, counts)
            }
            Self::LeakAround(places, reach) => {
                gap::leak_around(places, reach, mask, truth, receivers, counts)
            }
            Self::EdgeDisplacement => {
                edge::displacement(case_truth.truth.size, mask, truth, &case_truth.truth.pixels)
            }
            Self::Seams => {
                cube_seams::wrong_within(mask, truth, |i| counts(i) && is_on_seam(case_truth, i))
            }
            Self::WrongNear(part) => band::wrong_within(mask, truth, |i| {
                counts(i) && is_in_band(case_truth, part, i)
            }),
            Self::PenumbraRmse => penumbra::rmse(mask, truth, counts),
            Self::PenumbraWidth => {
                let places = shadow_places(case_truth);
                let widths = places.widths(mask, truth, receivers, LEVEL, counts);
                mean_width_error(&widths)
            }
            Self::AllLit => darkened_share(mask, &case_truth.truth.pixels),
            Self::Fill | Self::Shimmer | Self::ChangeError | Self::CascadeSeams => 0.0,
        }
    }

    /// Returns the figure's limits on this case; [`Measure::reason`] explains them.
    /// [`Moving::limits`](super::Moving::limits) adds bounds from truth's own movement.
    pub fn limits(&self, case_truth: &CaseTruth) -> VerdictLimits {
        let counts = |i: usize| case_truth.counts(i);
        let ideal = self.figure(case_truth, &case_truth.ideal);
        // Evaluated on demand: not all measures need it.
        let without_shadow = || self.without_shadow(case_truth);
        match *self {
            Self::Acne | Self::AcneByDistance | Self::Leak | Self::Wrong => {
                SHARE.raised_by(2.0 * ideal)
            }
            Self::Rmse => {
                VerdictLimits::over_ideal(ideal, STEP).capped_by_no_shadow(without_shadow())
            }
            Self::Gap(contact) => {
                let pixel = contact.pixel(&case_truth.truth.receivers, NEAR_CONTACT, counts);
                VerdictLimits::over_ideal(ideal, 1e3 * pixel).capped_by_no_shadow(without_shadow())
            }
            Self::LostShadow
            | Self::ContactLeak(..)
            | Self::LeakAround(..)
            | Self::WrongNear(_) => {
                VerdictLimits::over_ideal(ideal, BAND_SHARE).capped_by_no_shadow(without_shadow())
            }
            Self::EdgeDisplacement => {
                VerdictLimits::over_ideal(ideal, HALF_PIXEL).capped_by_no_shadow(without_shadow())
            }
            Self::Seams => {
                VerdictLimits::over_ideal(ideal, SMALL_SHARE).capped_by_no_shadow(without_shadow())
            }
            Self::PenumbraRmse => VerdictLimits::new(
                penumbra::ray_noise(&case_truth.truth.visibility, RAYS, counts),
                0.5 * penumbra::rmse(&case_truth.hard, &case_truth.truth.visibility, counts),
            ),
            Self::PenumbraWidth => VerdictLimits::new(25.0, 50.0),
            Self::AllLit => VerdictLimits::new(0.0, 0.0),
            Self::CascadeSeams => {
                VerdictLimits::new(BAND_SHARE, super::verdict::FAILS_AT * BAND_SHARE)
            }
            Self::ScaleDrift(_) | Self::Shimmer | Self::ChangeError => {
                VerdictLimits::new(STEP, super::verdict::FAILS_AT * STEP)
            }
            Self::Fill => VerdictLimits::new(4.0 * SCREEN, 16.0 * SCREEN),
        }
    }
}

impl Measure {
    /// Returns the figure of a mask that is lit all over.
    pub fn without_shadow(&self, case_truth: &CaseTruth) -> f64 {
        let all_lit = vec![1.0; case_truth.ideal.len()];
        self.figure(case_truth, &all_lit)
    }

    /// Returns limits derived from truth of another scene. They are scaled by the figure of no
    /// shadow here over the one there. If the one there is 0, returns the case's own limits.
    pub fn limits_from(&self, case_truth: &CaseTruth, elsewhere: &CaseTruth) -> VerdictLimits {
        let there = self.without_shadow(elsewhere);
        if there > 0.0 {
            let here = self.without_shadow(case_truth);
            self.limits(elsewhere).times(here / there)
        } else {
            self.limits(case_truth)
        }
    }
}

/// Distance behind a contact within which rows of pixels are counted, metres.
const NEAR_CONTACT: f32 = 0.1;

/// Pixels of the image that fill refers to, millions.
pub(super) const SCREEN: f64 = 1280.0 * 720.0 * 1e-6;

/// Returns the mean deviation of width ratios from 1, percent; 0 without any.
fn mean_width_error(ratios: &[Option<f64>]) -> f64 {
    let errors: Vec<f64> = ratios
        .iter()
        .flatten()
        .map(|ratio| (ratio - 1.0).abs())
        .collect();
    100.0 * errors.iter().sum::<f64>() / errors.len().max(1) as f64
}

/// Returns the percentage of pixels that the mask darkens at all, of those that don't face away
/// from the light.
fn darkened_share(mask: &[f32], pixels: &[Pixel]) -> f64 {
    let facing = (0..mask.len()).filter(|&i| matches!(pixels[i], Pixel::Counted | Pixel::Empty));
    open::share(facing.map(|i| mask[i] < 1.0))
}

fn worst(bins: [f64; open::BINS]) -> f64 {
    bins.into_iter().fold(0.0, f64::max)
}

/// Returns the RMSE over the pixels that count. It is NaN, which fails, if the mask has another
/// size or contains values outside 0..=1.
pub(super) fn rmse(case_truth: &CaseTruth, mask: &[f32]) -> f64 {
    let truth = &case_truth.truth;
    Errors::measure(truth.size, mask, &truth.visibility, &truth.pixels)
        .map_or(f64::NAN, |errors| errors.rmse)
}

/// Reports whether a pixel shows a point near a seam of the first light's cube map.
fn is_on_seam(case_truth: &CaseTruth, i: usize) -> bool {
    let light = case_truth.lights.first().and_then(Light::position);
    let from_light = case_truth.truth.receivers.position(i) - light.unwrap_or_default();
    cube_seams::is_on_seam(from_light, case_truth.map_size, SEAM_TEXELS)
}

/// Reports whether a pixel shows a point in a band, under the first light.
fn is_in_band(case_truth: &CaseTruth, part: Band, i: usize) -> bool {
    let position = case_truth.truth.receivers.position(i);
    let light = case_truth.lights.first();
    light.is_some_and(|light| part.holds(light, position))
}

/// Number of points along each caster's upright axis.
const PLACES: usize = 5;

/// Returns the points on the floor that the first light's centre projects from all instances but
/// the first (the floor).
fn shadow_places(case_truth: &CaseTruth) -> ShadowPlaces {
    let light = case_truth
        .lights
        .first()
        .map(super::case_truth::without_extent);
    let light_position = light.and_then(|light| light.position()).unwrap_or_default();
    let casters = case_truth.scene.instances.iter().skip(1);
    ShadowPlaces(
        casters
            .map(|caster| places_of(case_truth, caster, light_position))
            .collect(),
    )
}

/// Returns the shadows of [`PLACES`] points along an instance's upright axis on the floor, y = 0.
fn places_of(case_truth: &CaseTruth, caster: &Instance, light_position: Vec3) -> Vec<Vec3> {
    let mesh = &case_truth.scene.meshes[caster.mesh];
    let corners = mesh
        .positions
        .iter()
        .map(|p| caster.world_from_local.transform_point3(*p));
    let bounds = Aabb::from_points(corners);
    let mut places = Vec::with_capacity(PLACES);
    for k in 0..PLACES {
        let y = bounds.min.y + (bounds.max.y - bounds.min.y) * k as f32 / (PLACES - 1) as f32;
        let point = bounds.center().with_y(y);
        // Intersect the ray from the light through the point with y = 0.
        let t = light_position.y / (light_position.y - point.y);
        places.push(light_position + (point - light_position) * t);
    }
    places
}
