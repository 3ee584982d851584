//! Fits of lights with a position: one pyramid, or a cube's six.

use crate::{
    geometry::Geometry,
    light_space::{
        LightSpace,
        caster_set::CasterSet,
        depth_range::{ViewPyramid, depth_range_of},
        fit::{
            input::{ANGLE_PADDING, FitInput},
            kind::Fit,
            lamp::{Lamp, MIN_NEAR_OVER_FAR, SquarePyramid, WIDEST_HALF_ANGLE},
            memory::Cone,
            points::{bounds_in, caster_points, receiver_points},
        },
        layers::{Arrangement, LightSpaces, cube_face_views},
        look_along, perspective,
    },
    recipe_error::RecipeError,
    scene::light::Light,
};
use glam::{Mat4, Vec3};
use std::ops::Range;

/// Returns the light space of a single map: one square pyramid. Parameters as for
/// [`Fit::light_space`].
///
/// Errors if it would be wider than [`WIDEST_HALF_ANGLE`] allows.
pub(super) fn single(
    fit: &Fit,
    input: &FitInput<'_>,
    size: u32,
    margin: f32,
) -> Result<LightSpace, RecipeError> {
    let eye = input.view.light.position().unwrap_or_default();
    let lamp = if *fit == Fit::Tight {
        Lamp::new(input, eye, size, margin)
    } else {
        None
    };
    let Cone { axis, half_angle } = cone(input, eye, lamp.as_ref())?;
    if half_angle.to_degrees() > WIDEST_HALF_ANGLE {
        return Err(RecipeError::unsupported_because(format!(
            "the {} light needs a cone of {:.0} degrees (a spot its own, others one that holds all casters), and one map \
             covers at most {:.0}: use `Layout::Cube`",
            input.view.light.kind(),
            2.0 * half_angle.to_degrees(),
            2.0 * WIDEST_HALF_ANGLE
        )));
    }
    let view_from_world = look_along(eye, axis, Vec3::Y)?;
    let widened = widen_half_angle(half_angle, size, margin);
    let [near, far] = match (fit, lamp) {
        (Fit::Manual { extents, .. }, _) => [extents.near, extents.far],
        (_, Some(lamp)) => range(
            lamp.near_plane(&view_from_world, f64::from(widened.tan())),
            far_plane(input, &view_from_world),
        ),
        (_, None) => whole_range(input, &view_from_world, widened),
    };
    Ok(LightSpace {
        view_from_world,
        clip_from_view: perspective(2.0 * widened, 1.0, near, far)?,
    })
}

/// Returns the six faces of a cube. Each is slightly wider than 90 degrees, so that kernels stay
/// within the face of their receiver.
pub(super) fn cube(
    fit: &Fit,
    input: &FitInput<'_>,
    eye: Vec3,
    size: u32,
    margin: f32,
) -> Result<LightSpaces, RecipeError> {
    // A face of half angle a, widened by the kernel's reach, has the tangent `tan(a) size / inner`.
    // With a = 45 degrees it must be at most that of the greatest half angle.
    let widest_tangent = WIDEST_HALF_ANGLE.to_radians().tan();
    let inner = size as f32 - 2.0 * margin - 2.0;
    if inner < size as f32 / widest_tangent && margin > 0.0 {
        return Err(RecipeError::unsupported_because(format!(
            "a kernel that reaches {margin} texels is too wide for a cube's faces of {size}: use greater maps or a \
             smaller kernel"
        )));
    }
    let half_angle = widen_half_angle(45.0_f32.to_radians(), size, margin);
    let lamp = if *fit == Fit::Tight {
        Lamp::new(input, eye, size, margin)
    } else {
        None
    };
    let mut out = LightSpaces {
        spaces: Vec::new(),
        casters: Vec::new(),
        arrangement: Arrangement::Cube,
    };
    let nears = lamp
        .as_ref()
        .map(|lamp| lamp.nears(f64::from(half_angle.tan())))
        .transpose()?;
    for (i, view_from_world) in cube_face_views(eye)?.into_iter().enumerate() {
        let [near, far] = match (fit, &lamp, nears) {
            (_, Some(lamp), Some(nears)) => range(nears[i], lamp.far as f32),
            (Fit::Manual { extents, .. }, ..) => [extents.near, extents.far],
            _ => whole_range(input, &view_from_world, half_angle),
        };
        let needed = match nears {
            Some(nears) => nears[i].is_some(),
            None => is_needed(input, &view_from_world, half_angle),
        };
        let clip_from_view = perspective(2.0 * half_angle, 1.0, near, far)?;
        out.spaces.push(LightSpace {
            view_from_world,
            clip_from_view,
        });
        out.casters.push(if needed {
            CasterSet::All
        } else {
            CasterSet::none()
        });
    }
    Ok(out)
}

/// Returns whether one map may replace a cube: for a spot light, if its texels are no larger than a
/// cube's, or if it could contain all casters.
pub(super) fn suffices(
    one: &LightSpace,
    input: &FitInput<'_>,
    eye: Vec3,
    size: u32,
    margin: f32,
) -> bool {
    let tangent = 1.0 / one.clip_from_view.x_axis.x;
    spot_cone(input.view.light).is_some()
        || tangent <= widen_half_angle(45.0_f32.to_radians(), size, margin).tan()
        || input.cone_around_casters(eye).half_angle.to_degrees() <= WIDEST_HALF_ANGLE
}

/// Returns a half angle (radians) widened by the kernel's reach, so that samples around the
/// outermost receivers stay on the map.
fn widen_half_angle(half_angle: f32, size: u32, margin: f32) -> f32 {
    let tangent = half_angle.tan() * size as f32 / super::parallel::inner_texels(size, margin);
    // Limit the angle: a kernel as wide as the map would widen it without bound.
    tangent
        .atan()
        .min(WIDEST_HALF_ANGLE.to_radians().max(half_angle))
}

/// Returns the cone of a spot light; `None` for other lights.
fn spot_cone(light: &Light) -> Option<Cone> {
    match *light {
        Light::Spot {
            direction, outer, ..
        } => Some(Cone {
            axis: direction,
            half_angle: outer,
        }),
        Light::Directional { .. }
        | Light::Point { .. }
        | Light::Rect { .. }
        | Light::Disc { .. } => None,
    }
}

/// Returns the cone that one map must cover: that of a spot light, or the one around all casters.
/// It is narrowed to the casters that matter if `lamp` is given.
fn cone(input: &FitInput<'_>, eye: Vec3, lamp: Option<&Lamp<'_>>) -> Result<Cone, RecipeError> {
    let own_cone = spot_cone(input.view.light);
    let widest = own_cone.unwrap_or_else(|| input.cone_around_casters(eye));
    let Some(lamp) = lamp else {
        return Ok(widest);
    };
    if widest.half_angle.to_degrees() <= WIDEST_HALF_ANGLE {
        let tangent = f64::from(widest.half_angle).tan();
        let axis = widest.axis;
        let narrowed = lamp.narrow_pyramid(SquarePyramid { axis, tangent })?;
        return Ok(Cone {
            axis: narrowed.axis,
            half_angle: padded_half_angle(&narrowed).min(widest.half_angle),
        });
    }
    // Use the cone of a spot light as it is. For others, the casters that matter may fit in one
    // map.
    if own_cone.is_none()
        && let Some(pyramid) = lamp.aimed_pyramid()?
    {
        return Ok(Cone {
            axis: pyramid.axis,
            half_angle: padded_half_angle(&pyramid),
        });
    }
    Ok(widest)
}

/// Returns a pyramid's half angle, radians, with padding for rounding.
fn padded_half_angle(pyramid: &SquarePyramid) -> f32 {
    pyramid.tangent.atan() as f32 + ANGLE_PADDING
}

/// Returns whether a cube's face contains both casters and visible receivers.
fn is_needed(input: &FitInput<'_>, view_from_world: &Mat4, half_angle: f32) -> bool {
    let Some(g) = input.view.geometry else {
        return true;
    };
    let pyramid = pyramid(view_from_world, half_angle);
    if !meets_any(&pyramid, g, g.casters()) {
        return false;
    }
    match input.view.receivers {
        Some(r) => r.positions().any(|p| pyramid.contains(p)),
        None => meets_any(&pyramid, g, g.receivers()),
    }
}

/// Returns whether a part of one of the triangles with these ids is in the pyramid.
fn meets_any(pyramid: &ViewPyramid, geometry: &Geometry, ids: Range<u32>) -> bool {
    depth_range_of(pyramid, geometry, ids).is_some()
}

fn pyramid(view_from_world: &Mat4, half_angle: f32) -> ViewPyramid {
    ViewPyramid {
        view_from_world: *view_from_world,
        tangents: [f64::from(half_angle.tan()); 2],
    }
}

/// Returns the distance of the nearest caster along the view, and one beyond the farthest receiver.
fn whole_range(input: &FitInput<'_>, view_from_world: &Mat4, half_angle: f32) -> [f32; 2] {
    let near = match input.view.geometry {
        Some(g) => {
            let pyramid = pyramid(view_from_world, half_angle);
            depth_range_of(&pyramid, g, g.casters()).map(|[near, _]| near)
        }
        // Without triangles, only the nearest corner of the casters' box and a distance are known.
        None => {
            let nearest_corner = -bounds_in(view_from_world, &caster_points(input)).max.z;
            // Points at a distance are nearest along the view in the corners of the pyramid.
            let tangent = half_angle.tan();
            let cosine = 1.0 / (1.0 + 2.0 * tangent * tangent).sqrt();
            let nearest = nearest_corner.max(input.view.nearest_caster * cosine);
            Some(nearest * 0.999).filter(|near| near.is_finite())
        }
    };
    range(near, far_plane(input, view_from_world))
}

/// Returns the far plane: twice the distance of the farthest receiver along the view. This barely
/// affects perspective depth, and rounding cannot move receivers beyond it.
fn far_plane(input: &FitInput<'_>, view_from_world: &Mat4) -> f32 {
    let receivers = bounds_in(view_from_world, &receiver_points(input));
    let far = if receivers.is_empty() {
        -bounds_in(view_from_world, &caster_points(input)).min.z
    } else {
        -receivers.min.z
    };
    if far.is_finite() && far > 0.0 {
        2.0 * far
    } else {
        1.0
    }
}

/// Returns near and far planes. The near plane is at most halfway to the far plane, and is exactly
/// there if `near` is `None`.
fn range(near: Option<f32>, far: f32) -> [f32; 2] {
    [
        near.unwrap_or(far * 0.5)
            .clamp(far * MIN_NEAR_OVER_FAR, far * 0.5),
        far,
    ]
}
