//! A three-d program without a window: one scene, one camera, one image.

use crate::context::{headless, renderer_name};
use anyhow::{Context as _, Result, ensure};
use rival_engines::{mesh_parts, sun};
use glutin::api::egl::context::PossiblyCurrentContext;
use three_d::{
    Camera, ClearState, Context, CpuMesh, DepthTexture2D, DirectionalLight, Gm, HasContext as _,
    Interpolation, Light, Mesh, PhysicalMaterial, Positions, RenderTarget, Srgba, Texture2D, Vec3,
    Viewport, Wrapping, radians, vec3,
};
use umbrage::{Geometry, Receivers, Scene, glam};

/// Intensity of the sun. three-d's white surfaces reflect one part in pi.
pub const INTENSITY: f32 = std::f32::consts::PI;
/// Distance of the target of three-d's camera, metres. The rounding of a distant target turns the
/// camera less.
const TARGET_DISTANCE: f32 = 1000.0;
/// Greatest relative difference of distances for which two programs show the same surface in a
/// pixel.
const SAME_DISTANCE: f32 = 1e-3;

type Object = Gm<Mesh, PhysicalMaterial>;

/// The running program.
pub struct ThreeDProgram {
    camera: Camera,
    casters: Vec<Object>,
    /// Objects that cast no shadow.
    others: Vec<Object>,
    direction: Vec3,
    colors: Texture2D,
    depths: DepthTexture2D,
    context: Context,
    /// The context, which must be dropped last.
    _current: PossiblyCurrentContext,
}

impl ThreeDProgram {
    /// Starts a program for the scene's first camera and its first light, which must be a sun.
    ///
    /// # Errors
    /// Returns an error without OpenGL, without a perspective camera, or without a sun.
    pub fn start(scene: &Scene, geometry: &Geometry) -> Result<Self> {
        let (direction, _) = sun(scene)?;
        let camera = scene.cameras.first().context("the scene has no camera")?;
        let (current, context) = headless()?;
        let size = camera.size;
        let colors = Texture2D::new_empty::<[f32; 4]>(
            &context,
            size.x,
            size.y,
            Interpolation::Nearest,
            Interpolation::Nearest,
            None,
            Wrapping::ClampToEdge,
            Wrapping::ClampToEdge,
        );
        let depths = DepthTexture2D::new::<f32>(
            &context,
            size.x,
            size.y,
            Wrapping::ClampToEdge,
            Wrapping::ClampToEdge,
        );
        let mut program = Self {
            camera: camera_of(camera)?,
            casters: Vec::new(),
            others: Vec::new(),
            direction: vector(direction),
            colors,
            depths,
            context,
            _current: current,
        };
        program.add_meshes(geometry);
        Ok(program)
    }

    /// Returns three-d's context.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// Returns the name of the OpenGL renderer.
    pub fn renderer_name(&self) -> String {
        renderer_name(&self.context)
    }

    /// Returns the direction of the sun's light, a unit vector.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Returns the sun, initially without shadows.
    pub fn sun(&self) -> DirectionalLight {
        DirectionalLight::new(&self.context, INTENSITY, Srgba::WHITE, self.direction)
    }

    /// Draws three-d's map of the sun, `size` texels on each side.
    ///
    /// # Errors
    /// Returns an error if three-d does.
    pub fn draw_map(&self, sun: &mut DirectionalLight, size: u32) -> Result<()> {
        let casters = self.casters.iter().map(|object| &object.geometry);
        sun.generate_shadow_map(size, casters)?;
        Ok(())
    }

    /// Draws a frame, and waits for it.
    pub fn frame(&self, light: &dyn Light) {
        let target = self.target();
        target.clear(ClearState::color_and_depth(0.0, 0.0, 0.0, 1.0, 1.0));
        let objects = self.casters.iter().chain(&self.others);
        target.render(&self.camera, objects, &[light]);
        // SAFETY: has no arguments, and only waits.
        unsafe { self.context.finish() };
    }

    /// Draws a frame, and returns its red channel, linear, rows from the top.
    ///
    /// # Errors
    /// Returns an error if OpenGL reports one.
    pub fn picture(&self, light: &dyn Light) -> Result<Vec<f32>> {
        self.frame(light);
        let target = self.target();
        let pixels: Vec<[f32; 4]> = target.read_color();
        // The target is still bound. Without a window there is no default target, which would be an
        // error.
        self.context.error_check()?;
        Ok(pixels.iter().map(|pixel| pixel[0]).collect())
    }

    /// Returns the fraction of visible pixels, 0..=1, in which the last frame shows the same
    /// surface as umbrage.
    pub fn share_seen_alike(&self, seen: &Receivers, camera: &umbrage::Camera) -> f64 {
        let depths = self.target().read_depth();
        let forward = -glam::Vec3::from(camera.world_from_view.matrix3.z_axis);
        let [near, far] = [self.camera.z_near(), self.camera.z_far()];
        let width = seen.size.x as usize;
        let mut alike = 0_u64;
        let mut all = 0_u64;
        for i in 0..seen.x.len() {
            if seen.triangle[i] == umbrage::NO_TRIANGLE {
                continue;
            }
            all += 1;
            // OpenGL's rows are from the bottom.
            let row = seen.size.y as usize - 1 - i / width;
            let clip_depth = 2.0 * depths[row * width + i % width] - 1.0;
            let distance = 2.0 * far * near / (far + near - clip_depth * (far - near));
            let place = glam::Vec3::new(seen.x[i], seen.y[i], seen.z[i]);
            let expected = (place - camera.eye()).dot(forward);
            alike += u64::from((distance - expected).abs() < SAME_DISTANCE * expected);
        }
        alike as f64 / all as f64
    }

    fn target(&self) -> RenderTarget<'_> {
        RenderTarget::new(
            self.colors.as_color_target(None),
            self.depths.as_depth_target(),
        )
    }

    /// Adds all triangles, with one white and rough material.
    fn add_meshes(&mut self, geometry: &Geometry) {
        for part in mesh_parts(geometry) {
            let vectors = |all: Vec<glam::Vec3>| all.into_iter().map(vector).collect();
            let mesh = CpuMesh {
                positions: Positions::F32(vectors(part.positions)),
                normals: Some(vectors(part.normals)),
                ..CpuMesh::default()
            };
            let mesh = Mesh::new(&self.context, &mesh);
            let objects = if part.casts {
                &mut self.casters
            } else {
                &mut self.others
            };
            objects.push(Gm::new(mesh, PhysicalMaterial::default()));
        }
    }
}

/// Returns three-d's camera for one of umbrage's.
fn camera_of(camera: &umbrage::Camera) -> Result<Camera> {
    let camera = camera.standard();
    let projection = camera.clip_from_view;
    ensure!(
        projection.w_axis.w == 0.0,
        "the camera has no perspective: use a scene with a perspective first camera"
    );
    // Depth is -(a z + b) / z, which is 0 at near and 1 at far.
    let a = projection.z_axis.z;
    let b = projection.w_axis.z;
    let near = b / a;
    let far = b / (a + 1.0);
    let eye = camera.eye();
    let axes = camera.world_from_view.matrix3;
    let forward = -glam::Vec3::from(axes.z_axis);
    let mut camera = Camera::new_perspective(
        Viewport::new_at_origo(camera.size.x, camera.size.y),
        vector(eye),
        vector(eye + TARGET_DISTANCE * forward),
        vector(axes.y_axis.into()),
        radians(2.0 * (1.0 / projection.y_axis.y).atan()),
        near,
        far,
    );
    camera.disable_tone_and_color_mapping();
    Ok(camera)
}

fn vector(v: glam::Vec3) -> Vec3 {
    vec3(v.x, v.y, v.z)
}
