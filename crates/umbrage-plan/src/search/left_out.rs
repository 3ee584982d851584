//! Work that can be omitted in addition to choosing a cheaper technique: shadows that are not
//! visible, casters less than a pixel wide, and redrawing unchanged images. Each omission is
//! evaluated, and reported with its savings and its error.

use super::{
    lights::{LightPlan, LightsPlan},
    outcome::{LeftOut, Omission, Plan},
    planner::Planner,
    setting::Setting,
};
use crate::{
    error::MeasureError,
    estimate::{scene::PlanScene, weighting::Weighting},
    motion::FrameMotion,
};
use glam::Vec3;
use umbrage_core::{Aabb, Camera, Geometry, Instance, Scene};
use umbrage_techniques::{FrameRules, Hard, LightPreset, MapTechnique, TechniquePreset, Update};

/// Width in pixels below which a caster is small, by its bounding sphere.
const SMALL_PIXELS: f32 = 1.0;

/// Finds what can be omitted from a plan. Returns an empty list if nothing was chosen.
pub(super) fn find(
    scene: &Scene,
    cameras: &[Camera],
    planner: &mut Planner<'_>,
    plan: &Plan,
) -> Result<Vec<LeftOut>, MeasureError> {
    let mut out = Vec::new();
    if plan.chosen.is_none() {
        return Ok(out);
    }
    out.extend(shadow(planner, plan)?);
    out.extend(left_out_redrawing(plan));
    out.extend(small_casters(scene, cameras, planner, plan)?);
    Ok(out)
}

/// Returns the omission of the whole shadow, if the chosen technique is `none`.
fn shadow(planner: &mut Planner<'_>, plan: &Plan) -> Result<Option<LeftOut>, MeasureError> {
    let Some(chosen) = plan.chosen.as_ref().filter(|s| s.technique == "none") else {
        return Ok(None);
    };
    let usual = TechniquePreset::from(MapTechnique::<Hard>::default());
    let Some(price) = planner.trials.price(&usual)? else {
        return Ok(None);
    };
    Ok(Some(LeftOut {
        what: Omission::Shadow,
        saved_ms: price.milliseconds - chosen.milliseconds,
        error_before: 0.0,
        estimate: chosen.estimate,
        is_taken: true,
    }))
}

/// Returns when the images of a setting must be redrawn.
fn update_of(motion: FrameMotion, setting: &Setting) -> Update {
    let is_drawn_once = setting.draw_ms > 0.0 && motion.keeps(setting.kept_as_camera_moves);
    match motion {
        FrameMotion::Still if is_drawn_once => Update::Once,
        FrameMotion::CameraMoves if is_drawn_once => Update::WhenSceneChanges,
        FrameMotion::Still | FrameMotion::CameraMoves | FrameMotion::AllMoves => Update::EveryFrame,
    }
}

impl LightsPlan {
    /// Returns the preset of one of its lights, with the rule for redrawing its images. Returns
    /// `None` if nothing is within the budget.
    pub fn light_preset(&self, light: &LightPlan) -> Option<LightPreset> {
        let chosen = light.chosen.as_ref()?;
        Some(LightPreset {
            technique: chosen.preset.clone(),
            frame: FrameRules {
                update: update_of(self.motion, chosen),
                ..FrameRules::default()
            },
        })
    }
}

/// Returns the omission of redrawing kept images.
fn left_out_redrawing(plan: &Plan) -> Option<LeftOut> {
    let chosen = plan.chosen.as_ref()?;
    let update = update_of(plan.motion, chosen);
    (update != Update::EveryFrame).then_some(LeftOut {
        what: Omission::Redrawing(update),
        saved_ms: chosen.draw_ms,
        error_before: chosen.estimate.error,
        estimate: chosen.estimate,
        is_taken: true,
    })
}

/// Evaluates the plan without the casters that all cameras see less than [`SMALL_PIXELS`] wide.
/// Returns `None` if there are none, or if nothing is drawn or traced.
fn small_casters(
    scene: &Scene,
    cameras: &[Camera],
    planner: &mut Planner<'_>,
    plan: &Plan,
) -> Result<Option<LeftOut>, MeasureError> {
    let Some(chosen) = plan.chosen.as_ref().filter(|s| s.technique != "none") else {
        return Ok(None);
    };
    // Remove the small casters.
    let mut without = scene.clone();
    let mut instances = 0;
    let mut triangles = 0;
    for instance in without.instances.iter_mut().filter(|i| i.casts) {
        let bounds = bounds(scene, instance);
        if cameras
            .iter()
            .all(|camera| width(camera, &bounds) < SMALL_PIXELS)
        {
            instance.casts = false;
            instances += 1;
            triangles += scene.meshes[instance.mesh].triangles.len();
        }
    }
    if instances == 0 {
        return Ok(None);
    }
    // Evaluate the chosen setting without them.
    let geometry = Geometry::bake(&without)?;
    let trials = &mut planner.trials;
    let mut views = Vec::new();
    for view in &trials.views {
        let mut other = PlanScene::new(
            view.scene.camera,
            view.scene.light,
            &geometry,
            Weighting::Even,
        )?;
        other.make_recipes_from(plan.bounds.renderer);
        views.push(other);
    }
    let Some((estimate, draw_ms, lookup_ms)) =
        trials.evaluate_on_scenes(&mut views, &chosen.preset)?
    else {
        return Ok(None);
    };
    let frame_ms = if plan.motion.keeps(chosen.kept_as_camera_moves) {
        lookup_ms
    } else {
        draw_ms + lookup_ms
    };
    // Compare with the same sample, so that only the omission differs.
    let before = trials.first_estimate(chosen);
    let is_within = match trials.prepare(&plan.bounds)? {
        Some(max_error) => estimate.is_surely_within(max_error),
        None => estimate.error <= before.error,
    };
    let saved_ms = chosen.milliseconds - frame_ms;
    Ok(Some(LeftOut {
        what: Omission::SmallCasters {
            below_pixels: SMALL_PIXELS,
            instances,
            triangles,
        },
        saved_ms,
        error_before: before.error,
        estimate,
        is_taken: is_within && (saved_ms > 0.0 || plan.motion.keeps(chosen.kept_as_camera_moves)),
    }))
}

/// Returns the box around an instance, world space.
fn bounds(scene: &Scene, instance: &Instance) -> Aabb {
    let place = |p: &Vec3| instance.world_from_local.transform_point3(*p);
    Aabb::from_points(scene.meshes[instance.mesh].positions.iter().map(place))
}

/// Returns the width at which a camera sees the sphere around a box, pixels. Returns infinity if
/// the camera is inside the sphere.
fn width(camera: &Camera, bounds: &Aabb) -> f32 {
    if bounds.is_empty() {
        return 0.0;
    }
    let rays = camera.rays();
    let diameter = bounds.diagonal();
    let distance = (camera.eye() - bounds.center()).length() - 0.5 * diameter;
    if distance <= 0.0 {
        return f32::INFINITY;
    }
    // Size of a pixel at that distance, metres; constant without perspective.
    let pixel = rays.origin_dx.length() + rays.dir_dx.length() / rays.dir.length() * distance;
    diameter / pixel
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::{bounds::Bounds, options::PlanOptions, plan};
    use glam::{Affine3A, UVec2};

    fn options(motion: FrameMotion) -> PlanOptions {
        PlanOptions {
            samples: 1024,
            size: Some(UVec2::new(160, 120)),
            motion,
            ..PlanOptions::default()
        }
    }

    fn plan_scene(scene: &Scene, motion: FrameMotion) -> Plan {
        plan(scene, &Bounds::error(0.08), &options(motion), &|_| {}).expect("can be planned")
    }

    fn cubes() -> Scene {
        umbrage_scenes::by_argument("cubes").expect("built in")
    }

    /// The plan omits hundreds of cubes a millimetre wide, but none of the visible cubes.
    #[test]
    fn specks_are_left_out_and_cubes_are_not() {
        let mut scene = cubes();
        let speck = scene
            .instances
            .iter()
            .find(|i| i.casts)
            .expect("a caster")
            .mesh;
        for k in 0..300 {
            let at = Vec3::new(0.1 * k as f32 - 15.0, 3.0, -20.0);
            let place = Affine3A::from_scale_rotation_translation(
                Vec3::splat(1e-3),
                glam::Quat::IDENTITY,
                at,
            );
            scene.instances.push(Instance::new(speck, place));
        }
        let found = plan_scene(&scene, FrameMotion::AllMoves);
        let rules = found.frame_rules();
        assert_eq!(
            rules.skip_casters_below_pixels, SMALL_PIXELS,
            "{:?}",
            found.left_out
        );
        let [left_out] = &found.left_out[..] else {
            panic!("one thing: {:?}", found.left_out);
        };
        assert!(matches!(
            left_out.what,
            Omission::SmallCasters { instances: 300, .. }
        ));
        assert!(left_out.saved_ms > 0.0, "{left_out:?}");
        assert!(
            (left_out.estimate.error - left_out.error_before).abs() < 0.005,
            "{left_out:?}"
        );
        let without = plan_scene(&cubes(), FrameMotion::AllMoves);
        assert!(without.left_out.is_empty() && without.frame_rules() == FrameRules::default());
    }

    #[test]
    fn what_is_kept_is_drawn_once() {
        let update = |motion| plan_scene(&cubes(), motion).frame_rules().update;
        assert_eq!(update(FrameMotion::Still), Update::Once);
        assert_eq!(update(FrameMotion::AllMoves), Update::EveryFrame);
        let moving = plan_scene(&cubes(), FrameMotion::CameraMoves);
        let chosen = moving.chosen.as_ref().expect("possible");
        let expected = if FrameMotion::CameraMoves.keeps(chosen.kept_as_camera_moves)
            && chosen.draw_ms > 0.0
        {
            Update::WhenSceneChanges
        } else {
            Update::EveryFrame
        };
        assert_eq!(moving.frame_rules().update, expected);
    }

    #[test]
    fn a_shadow_that_nobody_sees_is_left_out() {
        let scene = umbrage_scenes::by_argument("no-casters").expect("built in");
        let found = plan_scene(&scene, FrameMotion::AllMoves);
        let [left_out] = &found.left_out[..] else {
            panic!("one thing: {:?}", found.left_out);
        };
        assert!(
            left_out.what == Omission::Shadow && left_out.saved_ms > 0.0,
            "{left_out:?}"
        );
    }
}
