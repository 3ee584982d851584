//! Widths of penumbrae, from the gradient of truth along the surface where it is between dark and
//! lit.

use super::{sampled_truth::SampledTruth, scene::PlanScene};
use crate::{
    error::MeasureError,
    statistics::Sorted,
    truth::{PointTruth, ReceiverPoint, TruthOptions, trace_points},
};
use glam::{DVec2, DVec4, Vec3};
use umbrage_core::{
    LightSpace,
    light_sample::{bitangent, tangent},
};

/// Number of points at which widths are measured, sufficient for the 10 % and 90 % quantiles.
const POINTS: usize = 64;
/// Visibility range in the middle of a penumbra, where it changes evenly.
const MIDDLE: std::ops::RangeInclusive<f32> = 0.2..=0.8;
/// Distance to each side of a point at which truth is traced again, pixels. It is also the least
/// width that can be measured.
const STEP: f32 = 2.0;

/// Penumbra at a point, extrapolated from the gradient of visibility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Penumbra {
    position: Vec3,
    /// Vector along the surface from fully dark to fully lit; its length is the penumbra's width,
    /// metres.
    across: Vec3,
}

impl Penumbra {
    /// Returns its width in texels, on a map of `size` texels in the first of these spaces that
    /// contains its centre. Returns `None` if no space does.
    fn texels(&self, spaces: &[LightSpace], size: u32) -> Option<f64> {
        spaces.iter().find_map(|space| self.texels_in(space, size))
    }

    fn texels_in(&self, space: &LightSpace, size: u32) -> Option<f64> {
        let half = self.across * 0.5;
        let center = ndc(space, self.position)?;
        let from = ndc(space, self.position - half)?;
        let to = ndc(space, self.position + half)?;
        if center.abs().max_element() > 1.0 {
            return None;
        }
        // NDC have a width of 2.
        Some((to - from).length() * 0.5 * f64::from(size))
    }
}

/// Returns the position of a point in a light space, x and y in -1..=1 on the map. Returns `None`
/// behind the light.
fn ndc(space: &LightSpace, p: Vec3) -> Option<DVec2> {
    let clip: DVec4 = space.clip_from_world().as_dmat4() * p.as_dvec3().extend(1.0);
    let ndc = DVec2::new(clip.x, clip.y) / clip.w;
    (clip.w > 0.0 && ndc.is_finite()).then_some(ndc)
}

/// Finds penumbrae at some of the sampled receivers. Finds none under ideal lights.
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
    let requested: Vec<[ReceiverPoint; 4]> = chosen
        .iter()
        .map(|&i| points_around(scene, i, STEP * pixel * scene.receivers.distance[i]))
        .collect();
    let seen = trace_points(
        scene.geometry,
        scene.light,
        requested.as_flattened(),
        options,
    )?;
    let mut out = Vec::new();
    for (points, seen) in requested.iter().zip(seen.as_chunks::<4>().0) {
        out.extend(penumbra_between(points, seen));
    }
    Ok(out)
}

/// Returns the penumbra between four points on a surface, as two pairs of opposite points. Returns
/// `None` if visibility does not change.
fn penumbra_between(points: &[ReceiverPoint; 4], seen: &[PointTruth; 4]) -> Option<Penumbra> {
    let u = points[1].position - points[0].position;
    let v = points[3].position - points[2].position;
    let change_along_u = seen[1].visibility - seen[0].visibility;
    let change_along_v = seen[3].visibility - seen[2].visibility;
    // Gradient of visibility along the surface, 1 / m: `u` and `v` are perpendicular.
    let gradient =
        u * (change_along_u / u.length_squared()) + v * (change_along_v / v.length_squared());
    let position = (points[0].position + points[1].position) * 0.5;
    // Visibility changes by 1 from dark to lit.
    let across = gradient / gradient.length_squared();
    across.is_finite().then_some(Penumbra { position, across })
}

/// Returns the points a step (metres) to each side of a receiver along its surface, as two pairs of
/// opposite points.
fn points_around(scene: &PlanScene<'_>, i: usize, step: f32) -> [ReceiverPoint; 4] {
    let position = scene.receivers.position(i);
    let normal = scene.receivers.normal(i);
    let u = tangent(normal) * step;
    let v = bitangent(normal) * step;
    [-u, u, -v, v].map(|offset| ReceiverPoint {
        triangle: scene.receivers.triangle[i],
        ..ReceiverPoint::new(position + offset, normal, scene.geometry)
    })
}

/// Returns the 10 % and 90 % quantiles of the penumbrae's widths, texels on a map of `size` texels
/// in these spaces. Returns `None` without penumbrae.
pub(crate) fn texels(penumbrae: &[Penumbra], spaces: &[LightSpace], size: u32) -> Option<[f64; 2]> {
    let widths = penumbrae.iter().filter_map(|p| p.texels(spaces, size));
    let widths = Sorted::new(widths.collect());
    Some([widths.nearest(0.1)?, widths.nearest(0.9)?])
}
