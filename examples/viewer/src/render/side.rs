//! One side of a comparison: a light set whose lights all have the same technique.

use super::{
    FrameSettings,
    buffers::SceneBuffers,
    pipelines::{self, FRAME_GROUP, ForwardPipelines, Layouts, SET_GROUP, group},
    seen::SeenPart,
};
use crate::{
    lights::{EditLight, LightKind, MAX_LIGHTS},
    settings::Settings,
    side::SideSettings,
    stage::ViewerScene,
};
use anyhow::Result;
use umbrage::{
    Camera, Light,
    glam::{Mat4, Vec3},
    gpu::{FrameGeometry, LightId, LightSet, LightSetOptions, SetFrame, ShadowedLight, Unserved},
    scenes,
    techniques::{self, TechniqueEntry},
};

/// Bytes of the uniform `frame`: a matrix, three vectors, the rays through pixels, and four vectors
/// for each lamp.
const FRAME_BYTES: u64 = 16 * (4 + 3 + 6 + 4 * MAX_LIGHTS as u64);

/// A small scene for [`Side::refused_techniques`]: planar receivers, closed casters, a sun.
const CHECKED_SCENE: &str = "cubes";

pub(crate) struct Side {
    pub set: LightSet,
    /// The set's lights: those that are on, in the order of the settings.
    pub ids: Vec<LightId>,
    /// The lights of `ids`.
    lights: Vec<Light>,
    settings: SideSettings,
    /// Camera of the last preparation.
    camera: Option<Camera>,
    uniforms: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    /// The revision of the set's text, and its pipelines.
    forward: Option<(u64, ForwardPipelines)>,
}

impl Side {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layouts: &Layouts,
        scene: &SceneBuffers,
        settings: &SideSettings,
    ) -> Result<Self> {
        let options = LightSetOptions {
            group: SET_GROUP,
            ..LightSetOptions::default()
        };
        let mut set = LightSet::new(device, queue, options)?;
        scene.add_casters(&mut set)?;
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: FRAME_BYTES,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let frame_group = group(device, &layouts.frame, [uniforms.as_entire_binding()]);
        Ok(Self {
            set,
            ids: Vec::new(),
            lights: Vec::new(),
            settings: settings.clone(),
            camera: None,
            uniforms,
            frame_group,
            forward: None,
        })
    }

    /// Applies settings to the set's lights. `nth` is this side, 0 or 1. Returns whether their maps
    /// change.
    pub(super) fn apply(&mut self, settings: &Settings, nth: usize) -> Result<bool> {
        let wanted: Vec<Light> = enabled_lights(settings).collect();
        let settings = &settings.sides[nth];
        // Another kind of light needs another technique, since only directional lights have
        // cascades.
        let kinds = wanted.iter().map(std::mem::discriminant);
        let same_kinds = kinds.eq(self.lights.iter().map(std::mem::discriminant));
        if !same_kinds || *settings != self.settings {
            for id in self.ids.drain(..) {
                self.set.remove_light(id)?;
            }
            for light in &wanted {
                self.ids.push(self.set.add_light(ShadowedLight {
                    light: *light,
                    technique: settings.technique(light),
                    priority: 1.0,
                })?);
            }
            self.settings = settings.clone();
            self.lights = wanted;
            return Ok(true);
        }
        for ((id, old), new) in self.ids.iter().zip(&mut self.lights).zip(&wanted) {
            if old != new {
                self.set.set_light(*id, *new)?;
                *old = *new;
            }
        }
        Ok(false)
    }

    /// Prepares the set for a frame, and writes the uniforms.
    pub(super) fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layouts: &Layouts,
        scene: &SceneBuffers,
        frame: &FrameSettings<'_>,
    ) -> Result<()> {
        let geometry = &frame.stage.geometry;
        let of_set = SetFrame {
            camera: frame.camera,
            geometry: Some(FrameGeometry {
                triangles: geometry,
                revision: geometry.fingerprint(),
            }),
        };
        self.camera = None;
        self.set.prepare(&of_set)?;
        let (_, layout) = self.set.bind_group()?;
        let revision = self.set.wgsl_revision();
        if self
            .forward
            .as_ref()
            .is_none_or(|(made_for, _)| *made_for != revision)
        {
            let forward = pipelines::forward(
                device,
                layouts,
                self.set.wgsl(),
                layout,
                scene.alpha_test.as_ref(),
            )?;
            self.forward = Some((revision, forward));
        }
        let bytes = self.frame_uniforms(frame)?;
        queue.write_buffer(&self.uniforms, 0, bytemuck::cast_slice(&bytes));
        self.camera = Some(*frame.camera);
        Ok(())
    }

    /// Reports whether the set was prepared for this camera and these settings. `nth` is this side,
    /// 0 or 1.
    pub(crate) fn is_ready_for(&self, camera: &Camera, settings: &Settings, nth: usize) -> bool {
        self.camera.as_ref() == Some(camera)
            && self.settings == settings.sides[nth]
            && enabled_lights(settings).eq(self.lights.iter().copied())
    }

    /// Returns the names of the techniques that the set refuses for a kind of light, with their
    /// default settings.
    ///
    /// The test uses a small scene: refusals depend on the passes of a technique, the kind of light
    /// and the device. Some techniques first build lists of all triangles, which took 11 seconds
    /// for a scene of 2.4 million.
    ///
    /// # Errors
    /// Returns an error if there is no such scene.
    pub(crate) fn refused_techniques(&self, kind: LightKind) -> Result<Vec<String>> {
        let scene = scenes::by_argument(CHECKED_SCENE).map_err(anyhow::Error::msg)?;
        let stage = ViewerScene::of_scene(CHECKED_SCENE, CHECKED_SCENE, scene)?;
        let mut light = EditLight::of_scene(stage.lights[0], 1);
        light.retype(kind, &stage.bounds);
        let frame = SetFrame {
            camera: &stage.camera,
            geometry: Some(FrameGeometry {
                triangles: &stage.geometry,
                revision: stage.geometry.fingerprint(),
            }),
        };
        let is_refused = |entry: &&TechniqueEntry| {
            let technique = (entry.preset)().technique();
            self.set.check(&light.light, &*technique, &frame).is_err()
        };
        let refused = techniques::all().iter().filter(is_refused);
        Ok(refused.map(|entry| entry.name.to_owned()).collect())
    }

    fn frame_uniforms(&self, frame: &FrameSettings<'_>) -> Result<Vec<f32>> {
        let camera = frame.camera;
        let mut floats: Vec<f32> = clip_from_world(camera).to_cols_array().to_vec();
        floats.extend(camera.eye().extend(self.ids.len() as f32).to_array());
        floats.extend([0.16, 0.19, 0.25, 0.0]);
        floats.extend([0.09, 0.08, 0.07, 0.0]);
        floats.extend(rays(camera));
        let lights = frame.settings.lights.iter().filter(|light| light.is_on);
        for (light, id) in lights.zip(&self.ids) {
            floats.extend(lamp(light, self.set.index_of(*id)?));
        }
        floats.resize(FRAME_BYTES as usize / 4, 0.0);
        Ok(floats)
    }

    /// Draws the scene lit by this side's lights.
    pub(crate) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        scene: &SceneBuffers,
        seen: &SeenPart,
    ) -> Result<()> {
        let (group, _) = self.set.bind_group()?;
        let Some((_, forward)) = &self.forward else {
            anyhow::bail!("a side was drawn before it was prepared");
        };
        // Set bind groups once: they stay bound when pipelines of the same layout change.
        pass.set_bind_group(FRAME_GROUP, &self.frame_group, &[]);
        pass.set_bind_group(SET_GROUP, group, &[]);
        scene.draw(pass, forward, seen);
        Ok(())
    }

    /// Returns the lights without shadows, with reasons.
    fn refused_lights(&self) -> impl Iterator<Item = (LightId, String)> + '_ {
        let unserved = self.set.unserved_lights();
        let refused = unserved.filter(|(_, why)| !matches!(why, Unserved::Waiting));
        refused.map(|(id, why)| (id, why.to_string()))
    }

    /// Returns the distinct reasons for which lights have no shadows.
    pub(crate) fn refusals(&self) -> Vec<String> {
        let mut out: Vec<String> = self.refused_lights().map(|(_, reason)| reason).collect();
        out.sort();
        out.dedup();
        out
    }

    /// Returns the reason for which a light has no shadows. `None` if it has some.
    pub(crate) fn refusal(&self, light: LightId) -> Option<String> {
        let mut refused = self.refused_lights();
        refused.find_map(|(id, reason)| (id == light).then_some(reason))
    }
}

/// Returns the lights that are on.
fn enabled_lights(settings: &Settings) -> impl Iterator<Item = Light> + '_ {
    let lights = settings.lights.iter().filter(|light| light.is_on);
    lights.map(|light| light.light)
}

/// Returns the matrix from world to clip space.
pub(crate) fn clip_from_world(camera: &Camera) -> Mat4 {
    camera.clip_from_view * Mat4::from(camera.world_from_view.inverse())
}

/// Returns the rays through the pixels in the shader's layout.
fn rays(camera: &Camera) -> [f32; 24] {
    let rays = camera.rays();
    let vectors = [
        rays.origin,
        rays.origin_dx,
        rays.origin_dy,
        rays.dir,
        rays.dir_dx,
        rays.dir_dy,
    ];
    bytemuck::cast(vectors.map(|v| v.to_array()))
}

/// Returns a lamp in the shader's layout.
fn lamp(light: &EditLight, index: u32) -> [f32; 16] {
    let place = match light.light.position() {
        Some(position) => position.extend(1.0),
        None => light.light.direction_from(Vec3::ZERO).extend(0.0),
    };
    // Give lights without a cone cosines that no angle reaches.
    let (axis, inner, outer) = match light.light {
        Light::Spot {
            direction,
            inner,
            outer,
            ..
        } => {
            // Make the two different, as `smoothstep` requires.
            let outer_cosine = outer.cos();
            (
                direction.normalize(),
                inner.cos().max(outer_cosine + 1e-4),
                outer_cosine,
            )
        }
        _ => (Vec3::ZERO, -2.0, -3.0),
    };
    let vectors = [
        place.to_array(),
        axis.extend(outer).to_array(),
        light.linear_color().extend(index as f32).to_array(),
        [inner, 0.0, 0.0, 0.0],
    ];
    bytemuck::cast(vectors)
}
