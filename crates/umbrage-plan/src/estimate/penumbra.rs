//! How wide penumbrae are, by measurement: where truth lies between dark and lit, how fast it changes along the surface.

use super::{sampled_truth::SampledTruth, scene::PlanScene};
use crate::{
    MeasureError,
    statistics::Sorted,
    truth::{PointTruth, ReceiverPoint, TruthOptions, trace_points},
};
use glam::{DVec2, DVec4, Vec3};
use umbrage_core::{
    LightSpace,
    light_sample::{bitangent, tangent},
};

/// Points asked: tenths of their widths are told apart.
const POINTS: usize = 64;
/// Truth in the middle of a penumbra, where it changes evenly.
const MIDDLE: std::ops::RangeInclusive<f32> = 0.2..=0.8;
/// How far to each side of a point truth is asked again, pixels: narrower penumbrae are taken for this wide.
const STEP: f32 = 2.0;

/// A penumbra at a point: from wholly dark to wholly lit if it went on as it changes there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Penumbra {
    position: Vec3,
    /// Along the surface, as long as the penumbra is wide, metres.
    across: Vec3,
}

impl Penumbra {
    /// Its width on a map of `size` texels that lies in one of these spaces.
    fn texels(&self, spaces: &[LightSpace], size: u32) -> Option<f64> {
        let place = |space: &LightSpace, p: Vec3| {
            let clip: DVec4 = space.clip_from_world().as_dmat4() * p.as_dvec3().extend(1.0);
            let place = DVec2::new(clip.x, clip.y) / clip.w;
            (clip.w > 0.0 && place.is_finite()).then_some(place)
        };
        let half = self.across * 0.5;
        let on = |space: &LightSpace| {
            let middle = place(space, self.position)?;
            let ends = [
                place(space, self.position - half)?,
                place(space, self.position + half)?,
            ];
            (middle.abs().max_element() <= 1.0)
                .then(|| (ends[1] - ends[0]).length() * 0.5 * f64::from(size))
        };
        spaces.iter().find_map(on)
    }
}

/// Penumbrae at some of the sampled receivers; none under ideal lights.
pub(crate) fn find(
    scene: &PlanScene<'_>,
    sampled: &SampledTruth,
    options: &TruthOptions,
) -> Result<Vec<Penumbra>, MeasureError> {
    let in_middle: Vec<usize> = (0..sampled.truth.len())
        .filter(|&k| MIDDLE.contains(&sampled.truth[k].visibility) && !scene.light.is_ideal())
        .map(|k| sampled.sample.pixels[k] as usize)
        .collect();
    let step = in_middle.len().div_ceil(POINTS).max(1);
    let chosen: Vec<usize> = in_middle.into_iter().step_by(step).collect();
    let rays = scene.camera.rays();
    let pixel = rays.dir_dx.length() / rays.dir.length();
    let asked: Vec<[ReceiverPoint; 4]> = chosen
        .iter()
        .map(|&i| around(scene, i, STEP * pixel * scene.receivers.distance[i]))
        .collect();
    let seen = trace_points(scene.geometry, scene.light, asked.as_flattened(), options)?;
    let penumbrae = asked.iter().zip(seen.as_chunks::<4>().0);
    Ok(penumbrae
        .filter_map(|(points, seen)| at(points, seen))
        .collect())
}

/// Returns the penumbra between four points on a surface, two opposite ones after two; none where visibility does not change.
fn at(points: &[ReceiverPoint; 4], seen: &[PointTruth; 4]) -> Option<Penumbra> {
    let u = points[1].position - points[0].position;
    let v = points[3].position - points[2].position;
    let change_along_u = seen[1].visibility - seen[0].visibility;
    let change_along_v = seen[3].visibility - seen[2].visibility;
    // The gradient of visibility along the surface, 1 / m: `u` and `v` are perpendicular.
    let gradient =
        u * (change_along_u / u.length_squared()) + v * (change_along_v / v.length_squared());
    let position = (points[0].position + points[1].position) * 0.5;
    // From dark to lit visibility changes by 1.
    let across = gradient / gradient.length_squared();
    across.is_finite().then_some(Penumbra { position, across })
}

/// A step to each side of a receiver along its surface, two sides after two.
fn around(scene: &PlanScene<'_>, i: usize, step: f32) -> [ReceiverPoint; 4] {
    let (position, normal) = (scene.receivers.position(i), scene.receivers.normal(i));
    let (u, v) = (tangent(normal) * step, bitangent(normal) * step);
    let at = |offset: Vec3| ReceiverPoint {
        triangle: scene.receivers.triangle[i],
        ..ReceiverPoint::new(position + offset, normal, scene.geometry)
    };
    [at(-u), at(u), at(-v), at(v)]
}

/// The widths that a tenth of the penumbrae is narrower and a tenth wider than, texels on such a map; none without any.
pub(crate) fn texels(penumbrae: &[Penumbra], spaces: &[LightSpace], size: u32) -> Option<[f64; 2]> {
    let widths = penumbrae.iter().filter_map(|p| p.texels(spaces, size));
    let widths = Sorted::new(widths.collect());
    Some([widths.nearest(0.1)?, widths.nearest(0.9)?])
}
