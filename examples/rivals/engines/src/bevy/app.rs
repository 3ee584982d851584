//! A Bevy program without a window: one scene, one sun, one image.

use crate::plugin::{
    AngularDiameter, Casts, MaskOf, MaskedMaterial, ReadsMask, SunShadows, UmbragePlugin,
};
use anyhow::{Result, ensure};
use rival_engines::{mesh_parts, sun};
use bevy::{
    a11y::AccessibilityPlugin,
    app::{PluginsState, TerminalCtrlCHandlerPlugin},
    asset::RenderAssetUsages,
    camera::{Hdr, RenderTarget},
    core_pipeline::{
        prepass::{DepthPrepass, NormalPrepass},
        tonemapping::{DebandDither, Tonemapping},
    },
    light::{
        CascadeShadowConfigBuilder, DirectionalLightShadowMap, GlobalAmbientLight, NotShadowCaster,
        NotShadowReceiver, ShadowFilteringMethod,
    },
    mesh::PrimitiveTopology,
    pbr::ContactShadows,
    prelude::*,
    render::{
        RenderApp, RenderPlugin,
        gpu_readback::{Readback, ReadbackComplete},
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages},
        renderer::RenderDevice,
    },
    window::ExitCondition,
};
use half::f16;
use std::{
    sync::{Arc, Mutex},
    time::Instant,
};
use umbrage::{Geometry, Scene, ShadowTechnique};

/// Greatest number of frames for loading shaders and meshes.
const MAX_FRAMES: usize = 200;
/// An image is done after this many frames without a change, or after the greater number if a
/// filter's noise changes in each frame.
const UNCHANGED_FRAMES: usize = 3;
const MAX_DRAWN_FRAMES: usize = 16;

/// Source of the sun's shadows.
#[derive(Clone)]
pub enum ShadowSource {
    /// No shadows.
    Nothing,
    /// No shadows, but depth and normals are drawn first, as for the plug-in.
    NothingButPrepass,
    /// Bevy's own maps.
    Bevy(BevyShadows),
    /// A technique of this library, and whether its maps are redrawn in every frame.
    Umbrage(Arc<dyn ShadowTechnique>, bool),
}

/// Settings of Bevy's shadows of a sun.
#[derive(Clone, Copy, Debug)]
pub struct BevyShadows {
    /// Side of each cascade, texels.
    pub size: usize,
    /// Number of cascades.
    pub cascades: usize,
    /// Distance that they cover, metres.
    pub far: f32,
    /// The filter.
    pub filter: ShadowFilteringMethod,
    /// `DirectionalLight::soft_shadow_size`.
    pub soft: Option<f32>,
    /// `true` if contact shadows are on, with Bevy's default settings.
    pub contact: bool,
}

/// The image of the last readback, for the loop outside.
type LastPicture = Arc<Mutex<Option<Vec<u8>>>>;

/// The running program.
pub struct BevyProgram {
    app: App,
    size: UVec2,
    source: ShadowSource,
    last: LastPicture,
    picture: Handle<Image>,
}

impl BevyProgram {
    /// Starts a program for the scene's first camera and its first light, which must be a sun.
    pub fn start(scene: &Scene, geometry: &Geometry, source: &ShadowSource) -> Result<Self> {
        let camera = scene.cameras.first();
        let camera = camera.ok_or_else(|| anyhow::anyhow!("the scene has no camera"))?;
        let size = UVec2::new(camera.size.x, camera.size.y);
        let mut app = headless(source);
        ready(&mut app);
        let last = LastPicture::default();
        let mut images = app.world_mut().resource_mut::<Assets<Image>>();
        let target = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba16Float, None);
        let mut target = target;
        target.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let picture = images.add(target);
        let mask = images.add(mask_image(size));
        let world = app.world_mut();
        spawn_sun(world, scene, source)?;
        spawn_camera(world, camera, source, picture.clone(), mask.clone());
        spawn_meshes(world, geometry, source, &mask);
        Ok(Self {
            app,
            size,
            source: source.clone(),
            last,
            picture,
        })
    }

    /// Draws a frame, waits for it, and returns the time, milliseconds.
    pub fn frame(&mut self) -> Result<f64> {
        let start = Instant::now();
        self.app.update();
        let device = self.app.world().resource::<RenderDevice>();
        device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(start.elapsed().as_secs_f64() * 1000.0)
    }

    /// Draws frames until the image is done, and returns its red channel.
    pub fn picture(&mut self) -> Result<Vec<f32>> {
        let last = Arc::clone(&self.last);
        let reader = self
            .app
            .world_mut()
            .spawn(Readback::texture(self.picture.clone()));
        let reader = reader.id();
        let mut entity = self.app.world_mut().entity_mut(reader);
        entity.observe(move |read: On<ReadbackComplete>| {
            *last.lock().expect("no panic") = Some(read.data.clone());
        });
        let mut before = Vec::new();
        let mut unchanged = 0;
        let mut drawn_frames = 0;
        for _ in 0..MAX_FRAMES {
            self.frame()?;
            let Some(now) = self.last.lock().expect("no panic").take() else {
                continue;
            };
            if now.iter().any(|&byte| byte != 0) {
                drawn_frames += 1;
                unchanged = if now == before { unchanged + 1 } else { 0 };
            }
            before = now;
            if unchanged == UNCHANGED_FRAMES || drawn_frames == MAX_DRAWN_FRAMES {
                self.app.world_mut().despawn(reader);
                return red_channel(&before, self.size);
            }
        }
        anyhow::bail!("nothing was drawn in {MAX_FRAMES} frames")
    }

    /// Returns the bytes of maps and masks, and of the prepass that they need. Bevy doesn't report
    /// its sizes, so they are computed from its settings.
    pub fn bytes(&mut self) -> u64 {
        // An image of four bytes a pixel, such as the depth of the prepass.
        let image = 4 * u64::from(self.size.x * self.size.y);
        match &self.source {
            ShadowSource::Nothing => 0,
            // Depth and normals.
            ShadowSource::NothingButPrepass => 2 * image,
            ShadowSource::Bevy(bevy) => {
                let maps = 4 * (bevy.size * bevy.size * bevy.cascades) as u64;
                // Contact shadows read the depth of the prepass.
                maps + if bevy.contact { image } else { 0 }
            }
            ShadowSource::Umbrage(..) => {
                let render_app = self.app.sub_app(RenderApp);
                render_app.world().resource::<SunShadows>().bytes(self.size)
            }
        }
    }
}

fn headless(source: &ShadowSource) -> App {
    let mut app = App::new();
    let plugins = bevy::DefaultPlugins
        .build()
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..WindowPlugin::default()
        })
        .set(RenderPlugin {
            synchronous_pipeline_compilation: true,
            ..RenderPlugin::default()
        })
        // Several programs run in one process, and each frame is awaited.
        .disable::<bevy::log::LogPlugin>()
        .disable::<TerminalCtrlCHandlerPlugin>()
        .disable::<AccessibilityPlugin>()
        .disable::<PipelinedRenderingPlugin>();
    app.add_plugins(plugins)
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(GlobalAmbientLight {
            brightness: 0.0,
            ..GlobalAmbientLight::default()
        });
    match source {
        ShadowSource::Bevy(bevy) => {
            app.insert_resource(DirectionalLightShadowMap { size: bevy.size });
        }
        ShadowSource::Umbrage(technique, draws_all_again) => {
            // Use the smallest map: nothing is drawn into Bevy's own one.
            app.insert_resource(DirectionalLightShadowMap { size: 16 })
                .add_plugins(UmbragePlugin {
                    technique: Arc::clone(technique),
                    draws_all_again: *draws_all_again,
                });
        }
        ShadowSource::Nothing | ShadowSource::NothingButPrepass => {}
    }
    app
}

/// Waits until plug-ins are ready, like Bevy's runners.
fn ready(app: &mut App) {
    while app.plugins_state() == PluginsState::Adding {
        std::thread::yield_now();
    }
    app.finish();
    app.cleanup();
}

fn mask_image(size: UVec2) -> Image {
    let extent = Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: 1,
    };
    let mut image = Image::new_fill(
        extent,
        TextureDimension::D2,
        &1.0_f32.to_le_bytes(),
        TextureFormat::R32Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    image
}

fn spawn_sun(world: &mut World, scene: &Scene, source: &ShadowSource) -> Result<()> {
    let (direction, angular_diameter) = sun(scene)?;
    let along = Vec3::from_array(direction.to_array());
    let place = Transform::default().looking_to(along, Vec3::Y);
    let has_shadows = matches!(source, ShadowSource::Bevy(_) | ShadowSource::Umbrage(..));
    let mut light = DirectionalLight {
        shadow_maps_enabled: has_shadows,
        ..DirectionalLight::default()
    };
    let mut cascades = CascadeShadowConfigBuilder {
        num_cascades: 1,
        ..CascadeShadowConfigBuilder::default()
    };
    if let ShadowSource::Bevy(bevy) = source {
        light.soft_shadow_size = bevy.soft;
        light.contact_shadows_enabled = bevy.contact;
        cascades.num_cascades = bevy.cascades;
        cascades.maximum_distance = bevy.far;
    }
    world.spawn((
        light,
        cascades.build(),
        place,
        AngularDiameter(angular_diameter),
    ));
    Ok(())
}

fn spawn_camera(
    world: &mut World,
    camera: &umbrage::Camera,
    source: &ShadowSource,
    picture: Handle<Image>,
    mask: Handle<Image>,
) {
    let matrix = umbrage::glam::Mat4::from(camera.world_from_view).to_cols_array();
    let place = Transform::from_matrix(Mat4::from_cols_array(&matrix));
    let projection = PerspectiveProjection {
        fov: 2.0 * (1.0 / camera.clip_from_view.y_axis.y).atan(),
        aspect_ratio: camera.size.x as f32 / camera.size.y as f32,
        ..PerspectiveProjection::default()
    };
    let mut entity = world.spawn((
        Camera3d::default(),
        Projection::Perspective(projection),
        place,
        RenderTarget::Image(picture.into()),
        Hdr,
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
    ));
    match source {
        ShadowSource::Nothing => {}
        ShadowSource::NothingButPrepass => {
            entity.insert((DepthPrepass, NormalPrepass));
        }
        ShadowSource::Bevy(bevy) => {
            entity.insert(bevy.filter);
            if bevy.contact {
                entity.insert(ContactShadows::default());
            }
        }
        ShadowSource::Umbrage(..) => {
            entity.insert(MaskOf(mask));
        }
    }
}

/// Adds all triangles to the world, in parts, with one white material.
fn spawn_meshes(
    world: &mut World,
    geometry: &Geometry,
    source: &ShadowSource,
    mask: &Handle<Image>,
) {
    let white = StandardMaterial {
        base_color: Color::WHITE,
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        double_sided: true,
        cull_mode: None,
        ..StandardMaterial::default()
    };
    let is_masked = matches!(source, ShadowSource::Umbrage(..));
    let plain = (!is_masked).then(|| {
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        MeshMaterial3d(materials.add(white.clone()))
    });
    let masked = is_masked.then(|| {
        let mut materials = world.resource_mut::<Assets<MaskedMaterial>>();
        let extension = ReadsMask { mask: mask.clone() };
        MeshMaterial3d(materials.add(MaskedMaterial {
            base: white,
            extension,
        }))
    });
    for part in mesh_parts(geometry) {
        let positions: Vec<[f32; 3]> = part.positions.iter().map(|p| p.to_array()).collect();
        let normals: Vec<[f32; 3]> = part.normals.iter().map(|n| n.to_array()).collect();
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::all())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
        let handle = world.resource_mut::<Assets<Mesh>>().add(mesh);
        let mut entity = world.spawn((Mesh3d(handle), Transform::default()));
        if let Some(material) = &plain {
            entity.insert(material.clone());
        }
        if let Some(material) = &masked {
            entity.insert(material.clone());
        }
        match (part.casts, is_masked) {
            (true, true) => {
                entity.insert(Casts);
            }
            (true, false) => {}
            (false, _) => {
                entity.insert(NotShadowCaster);
            }
        }
        if !part.receives {
            entity.insert(NotShadowReceiver);
        }
    }
}

/// Returns the first of four 16-bit floats of each pixel.
fn red_channel(bytes: &[u8], size: UVec2) -> Result<Vec<f32>> {
    let pixels = (size.x * size.y) as usize;
    ensure!(
        bytes.len() == 8 * pixels,
        "{} bytes came back of {} x {} pixels: use a width that is a multiple of 32",
        bytes.len(),
        size.x,
        size.y
    );
    let halves = bytes.chunks_exact(8);
    Ok(halves
        .map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32())
        .collect())
}
