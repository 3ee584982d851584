//! The motion of a failure: the camera, its projection or the light follows a path, back and forth.

use crate::{camera::ViewCamera, stage::ViewerScene};
use umbrage::{
    Camera, Light, View,
    cpu::Cpu,
    glam::{Mat4, UVec2, Vec3},
    scenes::motion::{Motion, MotionStep, MovingScene, jitter, texel_width},
};

/// Number of steps of the motion in one direction. It is greater than in the stability matrix, for
/// a longer animation.
const STEPS: u32 = 60;
const STEPS_A_SECOND: f32 = 20.0;
/// Size of the image whose receivers determine the fit of the first map, pixels.
pub(crate) const FITTED: UVec2 = UVec2::new(320, 180);

/// A motion that can run or pause.
pub(crate) struct MotionPath {
    pub moving: MovingScene,
    /// The width of a texel of the first map, metres.
    texel: f64,
    pub is_running: bool,
    /// Position of the motion. `None` before it begins, and after the user moves the camera or the
    /// light.
    pub under_way: Option<UnderWay>,
}

/// A motion that has begun.
#[derive(Clone, Copy)]
pub(crate) struct UnderWay {
    /// The view at the start.
    pub view: ViewCamera,
    /// The light at the start.
    pub light: Option<Light>,
    pub seconds: f32,
}

impl UnderWay {
    /// Returns the index of the step, which counts up to the last step and back.
    fn index(&self) -> u32 {
        let steps = (self.seconds * STEPS_A_SECOND) as u32 % (2 * (STEPS - 1));
        steps.min(2 * (STEPS - 1) - steps)
    }
}

impl MotionPath {
    /// Returns the running motion of a stage seen through a camera, with maps of `map_size` texels
    /// a side.
    ///
    /// # Errors
    /// Returns an error if no map can be fitted to the view.
    pub(crate) fn new(
        moving: MovingScene,
        stage: &ViewerScene,
        view: &ViewCamera,
        map_size: u32,
    ) -> anyhow::Result<Self> {
        let camera = moving.motion.first_camera(&view.camera(FITTED));
        let texel = match stage.lights.first() {
            Some(light) => {
                let receivers = Cpu::new().receivers(&camera, &stage.geometry)?;
                let view = View::new(&camera, light, &stage.geometry).with_receivers(&receivers);
                texel_width(&view, map_size)?
            }
            None => 0.0,
        };
        Ok(Self {
            moving,
            texel,
            is_running: true,
            under_way: None,
        })
    }

    fn step(&self, under_way: &UnderWay) -> MotionStep {
        MotionStep {
            index: under_way.index(),
            count: STEPS,
            texel: self.texel,
        }
    }

    /// Returns the current step. `None` if the motion has not begun.
    pub(crate) fn index(&self) -> Option<u32> {
        self.under_way.as_ref().map(UnderWay::index)
    }

    /// Returns the current camera. `first` is that of the view at the start.
    pub(crate) fn camera(&self, first: &Camera) -> Camera {
        let Some(under_way) = &self.under_way else {
            return *first;
        };
        if self.moving.motion == Motion::Jitter {
            return jittered_camera(first, under_way.index());
        }
        let step = self.step(under_way);
        self.moving.motion.camera(first, &step)
    }

    /// Returns the current light, if the motion has begun and has one.
    pub(crate) fn light(&self) -> Option<Light> {
        let under_way = self.under_way.as_ref()?;
        let step = self.step(under_way);
        Some(self.moving.motion.light(&under_way.light?, &step))
    }
}

/// Returns the camera with its projection offset within a pixel. Its depth stays reversed.
fn jittered_camera(camera: &Camera, index: u32) -> Camera {
    let pixels = jitter(index);
    let ndc = 2.0 * pixels / camera.size.as_vec2();
    // Multiply from the left, so that w scales the shift.
    let shift = Mat4::from_translation(Vec3::new(ndc.x, -ndc.y, 0.0));
    Camera {
        clip_from_view: shift * camera.clip_from_view,
        ..*camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bookmarks;
    use umbrage::Backend as _;

    #[test]
    fn paths_go_there_and_back() {
        let view = ViewCamera::new(
            &ViewerScene::nothing().camera,
            &ViewerScene::nothing().bounds,
        );
        let index = |steps: u32| {
            let seconds = (steps as f32 + 0.5) / STEPS_A_SECOND;
            let under_way = UnderWay {
                view,
                light: None,
                seconds,
            };
            under_way.index()
        };
        let last = STEPS - 1;
        assert_eq!((index(0), index(1), index(last)), (0, 1, last));
        assert_eq!(
            (index(last + 1), index(2 * last), index(2 * last + 1)),
            (last - 1, 0, 1)
        );
    }

    /// For each moving failure, the artefact changes at fixed points, and the fix changes less.
    #[test]
    fn cures_change_less_than_faults() {
        for bookmark in bookmarks::all() {
            let Some(moving) = bookmark.moving_scene() else {
                continue;
            };
            let scene = umbrage::scenes::by_argument(bookmark.scene).expect("built in");
            let stage = ViewerScene::of_scene(bookmark.scene, bookmark.scene, scene).expect("seen");
            let view = ViewCamera::new(&stage.camera, &stage.bounds);
            let light = stage.lights[0];
            let mut path =
                MotionPath::new(moving, &stage, &view, bookmarks::COARSE).expect("a map fits");
            let first = view.camera(UVec2::new(160, 90));
            let mut cpu = Cpu::new();
            let receivers = cpu.receivers(&first, &stage.geometry).expect("seen");
            let range = 0.5 * stage.bounds.diagonal();
            let mut change = |side: &crate::side::SideSettings| {
                let mut masks: Vec<Vec<f32>> = Vec::new();
                for index in 0..6_u8 {
                    path.under_way = Some(UnderWay {
                        view,
                        light: Some(light),
                        seconds: (f32::from(index) + 0.5) / STEPS_A_SECOND,
                    });
                    let camera = path.camera(&first);
                    let light = path.light().expect("a light");
                    let planned = View::new(&camera, &light, &stage.geometry);
                    let recipe = side.technique(&light).recipe(&planned).expect("a recipe");
                    let seen = planned.with_receivers(&receivers);
                    masks.push(cpu.render(&seen, &recipe).expect("a mask").mask);
                }
                let change = |pair: &[Vec<f32>]| {
                    let steps = pair[0].iter().zip(&pair[1]);
                    steps.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>()
                };
                masks.windows(2).map(change).sum::<f64>()
            };
            let fault = change(&bookmark.fault(range));
            let cure = change(&bookmark.fix(Some(&light), range));
            println!("{}: fault {fault:.1}, cure {cure:.1}", bookmark.name);
            assert!(path_moves(&path, &first), "{}", bookmark.name);
            assert!(
                fault > 0.0 && cure < fault,
                "{}: fault {fault}, cure {cure}",
                bookmark.name
            );
        }
    }

    fn path_moves(path: &MotionPath, first: &Camera) -> bool {
        let moved = path.camera(first);
        let far = moved.eye().distance(first.eye()) > 0.0;
        let turned = moved.world_from_view.transform_vector3(Vec3::NEG_Z)
            != first.world_from_view.transform_vector3(Vec3::NEG_Z);
        let widened = moved.clip_from_view != first.clip_from_view;
        far || turned || widened || path.moving.motion == Motion::Sun
    }
}
