//! Fits of cascades: the split of the camera's view, and the light space of each slice.
//!
//! A lookup uses the first layer that contains the receiver with the kernel's reach, wherever the
//! slices end. So every layer must be correct for everything on it. Tight slices begin, in depth,
//! at the first caster in their *column*, not at the first that their own receivers need. Their
//! lateral bounds include all positions at which a kernel may find a caster.
//!
//! If only the casters' box is known, the receivers are not: a floor far below the box may have its
//! shadow. Then a slice covers its part of the *column*, which extends from the box along the
//! light. The last slice ends where the camera sees the last of the column. Its depth range ends
//! at the box, and receivers beyond are compared at its far plane.
//!
//! A slice without shadows gets a space outside the scene, where nothing is looked up. Slices
//! overlap where results are blended. Recipes stay pure: stable slices are a function of the ends
//! of two frames ([`SliceEnds::stabilized`]).

use crate::{
    geometry::aabb::Aabb,
    invalid::{self, Invalid},
    light_space::{
        LightSpace,
        cascades::{Cascades, SliceEnds, Split},
        caster_set::CasterSet,
        fit::{
            frustum::{CameraFrustum, Slice, box_corners},
            input::FitInput,
            kind::Fit,
            parallel,
            points::{Points, bounds_in, caster_points, caster_reach, pad_box, receiver_points},
            receiver_split,
            stable::{self, SphereCenter},
        },
        layers::{Arrangement, CascadePick, LightSpaces},
    },
    recipe_error::RecipeError,
    view::View,
};
use glam::{DAffine3, DVec3, Mat4, Vec3};

/// Rounding allowance for slice limits that are computed from points, as a fraction of their
/// distance.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;
/// Least distance at which the split begins, as a fraction of the distance at which it ends.
const MIN_BEGIN_OVER_END: f64 = 1.0 / (1 << 20) as f64;
/// Overlap of a slice with the one before it, as a multiple of that slice's blend width. The
/// distance along the camera's view may be longer than that on the map.
const OVERLAP: f64 = 2.0;
/// Greatest end of the last slice, as a multiple of the distance from the eye to the farthest point
/// of the casters' box; for cameras without a far plane.
const MAX_END_OVER_BOX: f64 = (1 << 20) as f64;

/// Shared input of the fits of all slices.
#[derive(Clone, Debug)]
pub(super) struct CascadeInput<'a> {
    fit: Fit,
    cascades: Cascades,
    pub(super) input: FitInput<'a>,
    pub(super) frustum: CameraFrustum,
    /// Direction of the sun's rays.
    direction: Vec3,
    /// The light's view for tight fits.
    pub(super) view_from_world: Mat4,
}

impl<'a> CascadeInput<'a> {
    /// Returns the input for a valid view and a directional light with this direction.
    ///
    /// Errors if the fit doesn't follow the camera, or a number is out of its range.
    pub(super) fn new(
        fit: &Fit,
        cascades: &Cascades,
        view: &View<'a>,
        direction: Vec3,
    ) -> Result<Self, Invalid> {
        cascades.validate()?;
        let keeps_receivers = match fit {
            Fit::Tight => true,
            Fit::Stable { range } | Fit::AroundCamera { range } => {
                invalid::positive("stable fit's range", *range)?;
                cascades.split == Split::Receivers
            }
            Fit::Whole | Fit::Manual { .. } => {
                return Err(Invalid::new(
                    "cascades",
                    format!("have the {}, which doesn't follow the camera", fit.label()),
                    "use the fit `tight`, `stable` or `around_camera`",
                ));
            }
        };
        let view = View {
            receivers: view.receivers.filter(|_| keeps_receivers),
            ..*view
        };
        let input = FitInput::new(view);
        let frustum = CameraFrustum::new(view.camera);
        // Orient the maps so that the camera's view, along which the slices are lined up, runs up
        // the maps. The boxes around the slices are then smallest.
        let view_from_world = parallel::view(&input, direction, frustum.forward())?;
        Ok(Self {
            fit: *fit,
            cascades: *cascades,
            frustum,
            direction,
            view_from_world,
            input,
        })
    }

    /// Returns the ends of the slices.
    pub(super) fn ends(&self) -> SliceEnds {
        let count = self.cascades.count as usize;
        let split = match self.cascades.split {
            Split::Given(ends) => return ends,
            Split::Receivers => receiver_split::ends(self, count),
            Split::Log | Split::Practical { .. } => None,
        };
        let mut ends = split.unwrap_or_else(|| self.regular_ends(count));
        if let (Some(last), Some(column)) = (ends.last_mut(), self.seen_column()) {
            *last = last.max(column.end * (1.0 + ROUNDING));
        }
        SliceEnds::of_found(&ends)
    }

    /// Returns the ends by the formulas that depend only on the range.
    fn regular_ends(&self, count: usize) -> Vec<f64> {
        let all = self.range();
        let nearest = f64::from(self.cascades.nearest);
        let begin = all
            .begin
            .max(nearest)
            .max(all.end * MIN_BEGIN_OVER_END)
            .min(all.end);
        let share_of_log = match self.cascades.split {
            Split::Practical { lambda } => f64::from(lambda),
            Split::Log | Split::Receivers | Split::Given(_) => 1.0,
        };
        let end_of = |slice: usize| {
            let part = (slice + 1) as f64 / count as f64;
            if slice + 1 == count {
                return all.end;
            }
            let log = begin * (all.end / begin).powf(part);
            let uniform = begin + (all.end - begin) * part;
            uniform + (log - uniform) * share_of_log
        };
        (0..count).map(end_of).collect()
    }

    /// Returns the range of distances to be split.
    pub(super) fn range(&self) -> Slice {
        let near = self.frustum.near_distance();
        if let Fit::Stable { range } | Fit::AroundCamera { range } = self.fit {
            return Slice {
                begin: near,
                end: self.frustum.before_far(f64::from(range)).max(near),
            };
        }
        let seen = match &self.input.seen {
            Some(seen) => {
                let least = |sign: f64| {
                    let bound = |b: &Aabb| self.least_distance(b, sign);
                    let value = |p: Vec3| sign * self.frustum.distance(p.as_dvec3());
                    Points::Seen(seen).least(bound, value)
                };
                let begin = least(1.0);
                let end = -least(-1.0);
                (begin <= end).then_some(Slice { begin, end })
            }
            None => {
                let receivers = receiver_points(&self.input).bounds();
                let seen = self.frustum.seen_part(&receivers);
                seen.or_else(|| self.seen_column())
            }
        };
        let seen = seen.unwrap_or(Slice {
            begin: near,
            end: near,
        });
        Slice {
            begin: seen.begin * (1.0 - ROUNDING),
            end: seen.end * (1.0 + ROUNDING),
        }
    }

    /// Returns a lower bound of `sign` times the distance along the view in a box.
    fn least_distance(&self, b: &Aabb, sign: f64) -> f64 {
        if b.is_empty() {
            return f64::INFINITY;
        }
        let distances = b
            .corners()
            .map(|corner| sign * self.frustum.distance(corner.as_dvec3()));
        let least = distances.fold(f64::INFINITY, f64::min);
        least - least.abs() * ROUNDING
    }

    /// Returns the side of a slice's map, metres; the size of its texels is proportional to it.
    /// `receivers` is the box around its receivers, in the light's view.
    pub(super) fn side(&self, slice: Slice, receivers: &[DVec3; 2]) -> f64 {
        match self.fit {
            Fit::Stable { .. } | Fit::AroundCamera { .. } => {
                2.0 * stable::slice_radius(&self.frustum, slice, SphereCenter::of_fit(&self.fit))
            }
            Fit::Tight | Fit::Whole | Fit::Manual { .. } => {
                let extent = receivers[1] - receivers[0];
                extent.x.max(extent.y)
            }
        }
    }

    pub(super) fn is_stable(&self) -> bool {
        matches!(self.fit, Fit::Stable { .. } | Fit::AroundCamera { .. })
    }

    /// Returns [`Cascades::nearest`].
    pub(super) fn nearest(&self) -> f64 {
        f64::from(self.cascades.nearest)
    }

    /// Returns whether only the casters' box is known to a tight fit.
    fn knows_box_alone(&self) -> bool {
        !self.is_stable() && self.input.seen.is_none() && self.input.view.geometry.is_none()
    }

    /// Returns the corners (world space) of a slice's part of the column: what the casters' box,
    /// grown by `reach` metres across the light, may shadow. Empty if there is no such part.
    fn part_of_column(&self, slice: Slice, reach: f32) -> Vec<DVec3> {
        let casters = bounds_in(&self.view_from_world, &caster_points(&self.input));
        if casters.is_empty() {
            return Vec::new();
        }
        let light_from_world = DAffine3::from_mat4(self.view_from_world.as_dmat4());
        let slice_corners = self.frustum.slice_corners(slice);
        let depths = slice_corners.map(|p| light_from_world.transform_point3(p).z);
        let grow = DVec3::new(reach.into(), reach.into(), 0.0);
        let max = casters.max.as_dvec3() + grow;
        let min = casters.min.as_dvec3() - grow;
        // View z decreases away from the light.
        let min = min.with_z(depths.into_iter().fold(min.z, f64::min));
        let world_from_light = light_from_world.inverse();
        let column = box_corners(min, max).map(|p| world_from_light.transform_point3(p));
        self.frustum.part_of_body(slice, column)
    }

    /// Returns the range of distances of the visible part of the column; `None` if it isn't
    /// visible, or more than the casters' box is known.
    fn seen_column(&self) -> Option<Slice> {
        if !self.knows_box_alone() {
            return None;
        }
        let eye = self.frustum.world_from_view.translation;
        let to_corners = self.input.view.casters.corners();
        let farthest = to_corners
            .map(|p| p.as_dvec3().distance(eye))
            .fold(0.0, f64::max);
        let all = Slice {
            begin: self.frustum.near_distance(),
            end: self.frustum.before_far(farthest * MAX_END_OVER_BOX),
        };
        self.frustum.range_of(&self.part_of_column(all, 0.0))
    }

    /// Returns the box, in the light's view, around a slice's part of the column.
    fn column_bounds(&self, slice: Slice, is_last: bool, size: u32, margin: f32) -> Aabb {
        let casters = bounds_in(&self.view_from_world, &caster_points(&self.input));
        // A slice's texels are at most as large as those of a map of the whole box.
        let texel = casters.extent() / parallel::inner_texels(size, margin);
        let reach = texel.x.max(texel.y) * (margin + 2.0);
        let light_from_world = DAffine3::from_mat4(self.view_from_world.as_dmat4());
        let part = self.part_of_column(slice, reach);
        let mut b = Aabb::from_points(
            part.into_iter()
                .map(|p| light_from_world.transform_point3(p).as_vec3()),
        );
        if b.is_empty() {
            return b;
        }
        if is_last {
            // Receivers that no slice holds are looked up in the last one, at any depth.
            b.min.z = b.min.z.max(casters.min.z).min(b.max.z);
        }
        pad_box(b, caster_reach(&self.input))
    }

    /// Returns the light space of a slice; `None` if it can contain no shadow.
    fn space(
        &self,
        slice: Slice,
        is_last: bool,
        size: u32,
        margin: f32,
    ) -> Result<Option<LightSpace>, Invalid> {
        if slice.begin >= slice.end {
            return Ok(None);
        }
        if self.is_stable() {
            let view = &self.input.view;
            let center = SphereCenter::of_fit(&self.fit);
            let space = stable::slice(view, self.direction, slice, center, size, margin)?;
            return Ok(Some(space));
        }
        if let Some(seen) = &self.input.seen {
            let part = self
                .input
                .with_seen(seen.within_slice(self.frustum.slice_of_view(slice)));
            let receivers = bounds_in(&self.view_from_world, &receiver_points(&part));
            return self.tight(&part, &receivers, size, margin);
        }
        if self.knows_box_alone() {
            let receivers = self.column_bounds(slice, is_last, size, margin);
            return self.tight(&self.input, &receivers, size, margin);
        }
        let all_receivers = receiver_points(&self.input).bounds();
        let corners = self.frustum.part_of_box(slice, &all_receivers);
        let light_from_world = DAffine3::from_mat4(self.view_from_world.as_dmat4());
        let in_view = corners
            .iter()
            .map(|&corner| light_from_world.transform_point3(corner).as_vec3());
        let reach = all_receivers.min.abs().max(all_receivers.max.abs());
        let receivers = pad_box(Aabb::from_points(in_view), reach.max_element());
        self.tight(&self.input, &receivers, size, margin)
    }

    fn tight(
        &self,
        part: &FitInput<'_>,
        receivers: &Aabb,
        size: u32,
        margin: f32,
    ) -> Result<Option<LightSpace>, Invalid> {
        if receivers.is_empty() {
            return Ok(None);
        }
        parallel::tight_part(part, self.view_from_world, receivers, size, margin)
    }

    /// Returns the light spaces of all slices; parameters as for [`Fit::light_space`].
    pub(super) fn spaces(&self, size: u32, margin: f32) -> Result<LightSpaces, RecipeError> {
        let pick = CascadePick {
            reach: margin,
            blend: self.cascades.blend,
        };
        let mut out = LightSpaces {
            spaces: Vec::new(),
            casters: Vec::new(),
            arrangement: Arrangement::Cascades(pick),
        };
        let mut begin = self.frustum.near_distance().min(0.0);
        let ends = self.ends();
        let last = ends.as_slice().len() - 1;
        for (i, &end) in ends.as_slice().iter().enumerate() {
            let end = f64::from(end) * (1.0 + ROUNDING);
            let space = self.space(Slice { begin, end }, i == last, size, margin)?;
            begin = end - self.overlap(space.as_ref(), size, margin);
            let casters = if space.is_some() {
                CasterSet::All
            } else {
                CasterSet::none()
            };
            let nowhere = || parallel::nowhere(&self.input, self.view_from_world);
            out.spaces.push(space.map_or_else(nowhere, Ok)?);
            out.casters.push(casters);
        }
        Ok(out)
    }

    /// Returns the overlap of the slice behind one with this space, metres along the camera's view.
    /// It is large enough that receivers with blended results are in both slices.
    fn overlap(&self, space: Option<&LightSpace>, size: u32, margin: f32) -> f64 {
        let Some(space) = space.filter(|_| self.cascades.blend > 0.0) else {
            return 0.0;
        };
        let projection = space.clip_from_view;
        let widest = projection.x_axis.x.min(projection.y_axis.y);
        let texel = 2.0 / (f64::from(widest) * f64::from(size));
        OVERLAP * f64::from(self.cascades.blend + margin) * texel
    }
}
