//! The motion of a place of failure: the camera, its projection or the light goes along a path, there and back, until the user moves
//! either.

use crate::{app::App, camera::ViewCamera, stage::Stage};
use umbrage::{
    Camera, Light, View,
    cpu::Cpu,
    glam::{Mat4, UVec2, Vec3},
    scenes::motion::{Motion, MotionStep, MovingScene, jitter, texel_width},
};
use web_time::Duration;

/// Steps of the motion, one way: more than the matrix of failures plays, so that there is something to watch.
const STEPS: u32 = 60;
const STEPS_A_SECOND: f32 = 20.0;
/// Size of the picture by whose receivers the first map is fitted, pixels.
const FITTED: UVec2 = UVec2::new(320, 180);

/// A motion that can be played.
pub(crate) struct MotionPath {
    pub moving: MovingScene,
    /// The width of a texel of the first map, metres.
    texel: f64,
    pub is_playing: bool,
    /// Where it is; none before it begins, and after the user moved the camera or the light.
    under_way: Option<UnderWay>,
}

/// A motion that has begun.
#[derive(Clone, Copy)]
struct UnderWay {
    /// The view that it began from.
    view: ViewCamera,
    /// The light that it began from.
    light: Option<Light>,
    seconds: f32,
}

impl UnderWay {
    /// Returns the step, which goes from 0 to the last and back.
    fn index(&self) -> u32 {
        let steps = (self.seconds * STEPS_A_SECOND) as u32 % (2 * (STEPS - 1));
        steps.min(2 * (STEPS - 1) - steps)
    }
}

impl MotionPath {
    /// Returns the motion of a stage seen through a camera, with maps of `map_size` texels a side. It plays at once.
    ///
    /// # Errors
    /// Errors if no map can be fitted to what is seen.
    pub(crate) fn new(
        moving: MovingScene,
        stage: &Stage,
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
            is_playing: true,
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

    /// Returns the present step; none while it is not under way.
    pub(crate) fn index(&self) -> Option<u32> {
        self.under_way.as_ref().map(UnderWay::index)
    }

    /// Returns the present camera; `first` is that of the view that the motion began from.
    pub(crate) fn camera(&self, first: &Camera) -> Camera {
        let Some(under_way) = &self.under_way else {
            return *first;
        };
        if self.moving.motion == Motion::Jitter {
            return jittered(first, under_way.index());
        }
        let step = self.step(under_way);
        self.moving.motion.camera(first, &step)
    }

    /// Returns the present light; none if it has none of its own.
    fn light(&self) -> Option<Light> {
        let under_way = self.under_way.as_ref()?;
        let step = self.step(under_way);
        Some(self.moving.motion.light(&under_way.light?, &step))
    }
}

/// Returns the camera with its projection moved within a pixel; its depth stays reversed.
fn jittered(camera: &Camera, index: u32) -> Camera {
    let pixels = jitter(index);
    let ndc = 2.0 * pixels / camera.size.as_vec2();
    // Left of the projection, so that w multiplies the shift.
    let shift = Mat4::from_translation(Vec3::new(ndc.x, -ndc.y, 0.0));
    Camera {
        clip_from_view: shift * camera.clip_from_view,
        ..*camera
    }
}

impl App {
    /// Goes on along the path. What the user moved meanwhile, the camera or the light, ends it.
    pub(crate) fn follow_path(&mut self, passed: Duration) {
        let Some(path) = &mut self.path else {
            return;
        };
        let view = self.settings.view;
        let light = self.settings.lights.first_mut();
        let present = light.as_ref().map(|light| light.light);
        let is_as_left = match &path.under_way {
            Some(under_way) => under_way.view.stands_as(&view) && path.light() == present,
            None => true,
        };
        if !is_as_left {
            path.is_playing = false;
            path.under_way = None;
        }
        if !path.is_playing {
            return;
        }
        let under_way = path.under_way.get_or_insert(UnderWay {
            view,
            light: present,
            seconds: 0.0,
        });
        // How the camera is moved may have changed meanwhile: orbit, speed, parallel lines.
        under_way.view = view;
        // A long frame is no long way.
        under_way.seconds += passed.as_secs_f32().min(0.2);
        if let (Some(light), Some(to)) = (light, path.light()) {
            light.light = to;
        }
        self.touch();
    }

    /// Brings the view to where the path is, so that the user goes on from there; a step back if the user doesn't.
    pub(crate) fn leave_path(&mut self, steered: impl FnOnce(&mut Self) -> bool) {
        let begun = self.settings.view;
        let path = self.path.as_ref().filter(|path| path.under_way.is_some());
        if let Some(path) = path {
            let camera = path.camera(&begun.camera(FITTED));
            self.settings.view = begun.seen_as(&camera, &self.stage.bounds);
        }
        if steered(self) {
            self.touch();
            if let Some(path) = &mut self.path {
                path.is_playing = false;
                path.under_way = None;
            }
        } else {
            self.settings.view = begun;
        }
    }

    /// Plays the path, or pauses it.
    pub(crate) fn play_or_pause(&mut self) {
        match &mut self.path {
            Some(path) => path.is_playing = !path.is_playing,
            None => {
                self.message = Some("Nothing here moves by itself: F3 chooses a place of failure whose name says so, such as hills-pan.".to_owned());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bookmarks;
    use umbrage::Backend as _;

    #[test]
    fn paths_go_there_and_back() {
        let view = ViewCamera::new(&Stage::nothing().camera, &Stage::nothing().bounds);
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

    /// Of each moving place, the fault changes at points that stay, and the cure changes less.
    #[test]
    fn cures_change_less_than_faults() {
        for bookmark in bookmarks::all() {
            let Some(moving) = bookmark.moving() else {
                continue;
            };
            let scene = umbrage::scenes::by_argument(bookmark.scene).expect("built in");
            let stage = Stage::of_scene(bookmark.scene, bookmark.scene, scene).expect("seen");
            let view = ViewCamera::new(&stage.camera, &stage.bounds);
            let light = stage.lights[0];
            let mut path =
                MotionPath::new(moving, &stage, &view, bookmarks::COARSE).expect("a map fits");
            let first = view.camera(UVec2::new(160, 90));
            let mut cpu = Cpu::new();
            let receivers = cpu.receivers(&first, &stage.geometry).expect("seen");
            let range = 0.5 * stage.bounds.diagonal();
            let mut change = |side: &crate::settings::SideSettings| {
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
            let cure = change(&bookmark.cure(Some(&light), range));
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
