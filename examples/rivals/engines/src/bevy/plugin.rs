//! The plug-in: umbrage's shadows of the sun in Bevy's 3D scenes.
//!
//! Between the prepass and the main pass, a [`LightSet`] draws the maps from Bevy's vertex buffers,
//! and a mask from Bevy's depth and normals. The material reads the mask into
//! `directional_shadow_factor`. Bevy only applies that factor if the sun's own shadow maps are on.
//! They are therefore on, and nothing is drawn into them ([`NotShadowCaster`]).
//!
//! The plug-in supports one sun and one camera. Casters are opaque meshes of triangle lists without
//! skins, morphs or vertex shaders of the program.

use bevy::{
    asset::{AssetId, embedded_asset},
    camera::primitives::Aabb as BevyAabb,
    core_pipeline::{
        Core3d, Core3dSystems,
        prepass::{DepthPrepass, NormalPrepass, ViewPrepassTextures},
    },
    ecs::schedule::IntoScheduleConfigs as _,
    light::{DirectionalLight, NotShadowCaster},
    pbr::{ExtendedMaterial, MaterialExtension, MaterialPlugin, StandardMaterial},
    prelude::*,
    render::{
        Extract, ExtractSchedule, RenderApp,
        mesh::{
            RenderMesh,
            allocator::{MeshAllocator, MeshAllocatorSettings},
        },
        render_asset::RenderAssets,
        render_resource::AsBindGroup,
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        texture::GpuImage,
        view::ExtractedView,
    },
    shader::ShaderRef,
};
use std::{ops::Range, sync::Arc};
use umbrage::{
    Aabb, BackendError, Camera, Light, ShadowTechnique, glam,
    gpu::{
        CasterMesh, DepthBuffer, Indices, LightId, LightSet, LightSetOptions, MaskFormat,
        MaskInputs, MaskReceivers, NormalCoding, PositionFormat, SetFrame, SetNormals,
        ShadowedLight, VertexLayout,
    },
};

/// A material with the sun's shadow from a mask.
pub type MaskedMaterial = ExtendedMaterial<StandardMaterial, ReadsMask>;

/// Adds shadows to all cameras with a [`MaskOf`].
pub struct UmbragePlugin {
    /// The technique for the sun's shadows.
    pub technique: Arc<dyn ShadowTechnique>,
    /// `true` if all maps are redrawn in every frame, even without motion, for measuring times.
    pub draws_all_again: bool,
}

/// Marks a mesh that casts.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(NotShadowCaster)]
pub struct Casts;

/// The image of a camera that receives its mask, `R32Float` of the camera's size, usage `COPY_DST`.
#[derive(Component, Clone, Debug)]
#[require(DepthPrepass, NormalPrepass)]
pub struct MaskOf(pub Handle<Image>);

/// The angular diameter of a sun, radians. A sun without it is a point.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AngularDiameter(pub f32);

/// Additions to the standard material.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct ReadsMask {
    /// The camera's mask.
    #[texture(100, sample_type = "float", filterable = false)]
    pub mask: Handle<Image>,
}

impl MaterialExtension for ReadsMask {
    fn fragment_shader() -> ShaderRef {
        "embedded://rival_bevy/bevy/mask.wesl".into()
    }
}

impl Plugin for UmbragePlugin {
    fn build(&self, app: &mut App) {
        embedded_asset!(app, "mask.wesl");
        app.add_plugins(MaterialPlugin::<MaskedMaterial>::default());
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .insert_resource(SunShadows {
                technique: Arc::clone(&self.technique),
                draws_all_again: self.draws_all_again,
                made: None,
            })
            .init_resource::<SeenScene>()
            .add_systems(ExtractSchedule, extract)
            .add_systems(
                Core3d,
                draw_masks
                    .after(Core3dSystems::Prepass)
                    .before(Core3dSystems::MainPass),
            );
    }

    fn finish(&self, app: &mut App) {
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            // `exact` lists the casters on the device, from buffers that shaders read.
            let usage = bevy::render::render_resource::BufferUsages::STORAGE;
            let mut settings = render_app
                .world_mut()
                .get_resource_or_init::<MeshAllocatorSettings>();
            settings.extra_buffer_usages |= usage;
        }
    }
}

/// The casters in the main world, and the sun.
#[derive(Resource, Default)]
struct SeenScene {
    casters: Vec<SeenCaster>,
    sun: Option<SeenSun>,
    mask: Option<AssetId<Image>>,
}

#[derive(Clone, Copy, PartialEq)]
struct SeenSun {
    direction: Vec3,
    angular_diameter: f32,
}

#[derive(Clone, PartialEq)]
struct SeenCaster {
    mesh: AssetId<Mesh>,
    world_from_local: GlobalTransform,
    center: Vec3,
    half_extents: Vec3,
}

fn extract(
    mut seen: ResMut<SeenScene>,
    casters: Extract<Query<(&Mesh3d, &GlobalTransform, &BevyAabb), With<Casts>>>,
    suns: Extract<
        Query<(
            &DirectionalLight,
            &GlobalTransform,
            Option<&AngularDiameter>,
        )>,
    >,
    cameras: Extract<Query<&MaskOf>>,
) {
    seen.casters.clear();
    seen.casters
        .extend(casters.iter().map(|(mesh, place, bounds)| SeenCaster {
            mesh: mesh.id(),
            world_from_local: *place,
            center: bounds.center.into(),
            half_extents: bounds.half_extents.into(),
        }));
    let sun = suns.iter().find(|(sun, ..)| sun.shadow_maps_enabled);
    seen.sun = sun.map(|(_, place, diameter)| SeenSun {
        direction: place.forward().into(),
        angular_diameter: diameter.map_or(0.0, |diameter| diameter.0),
    });
    seen.mask = cameras.iter().next().map(|mask| mask.0.id());
}

/// The light set, and the data that it was built from.
#[derive(Resource)]
pub struct SunShadows {
    technique: Arc<dyn ShadowTechnique>,
    draws_all_again: bool,
    made: Option<Made>,
}

struct Made {
    set: LightSet,
    light: LightId,
    sun: SeenSun,
    casters: Vec<SeenCaster>,
    places: Vec<MeshPlace>,
}

/// Location of a caster's vertices and indices in Bevy's buffers.
#[derive(PartialEq)]
struct MeshPlace {
    vertices: Option<Range<u32>>,
    indices: Option<Range<u32>>,
}

impl MeshPlace {
    fn of_mesh(mesh: &AssetId<Mesh>, allocator: &MeshAllocator) -> Self {
        let vertices = allocator.mesh_vertex_slice(mesh);
        let indices = allocator.mesh_index_slice(mesh);
        Self {
            vertices: vertices.map(|slice| slice.range),
            indices: indices.map(|slice| slice.range),
        }
    }
}

impl SunShadows {
    /// Returns the bytes of maps and masks, and of the prepass images for them. Lists of casters
    /// are not included.
    pub fn bytes(&self, size: UVec2) -> u64 {
        let maps = self.made.as_ref().map_or(0, |made| made.set.map_bytes());
        // Depth and normals of the prepass, the mask, and the copy of it that the material reads:
        // four bytes each.
        maps + 4 * 4 * u64::from(size.x) * u64::from(size.y)
    }
}

impl Made {
    /// Returns a set with one sun and all casters, whose triangles stay in Bevy's buffers. `None`
    /// until Bevy has loaded them all.
    #[expect(
        clippy::too_many_arguments,
        reason = "a system of Bevy's names each resource"
    )]
    fn new(
        technique: &Arc<dyn ShadowTechnique>,
        seen: &SeenScene,
        sun: SeenSun,
        places: Vec<MeshPlace>,
        meshes: &RenderAssets<RenderMesh>,
        allocator: &MeshAllocator,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> std::result::Result<Option<Self>, BackendError> {
        let options = LightSetOptions::default();
        let mut set = LightSet::new(device.wgpu_device(), queue, options)?;
        for caster in &seen.casters {
            // Find the caster in Bevy's buffers. Wait if it is not loaded.
            let slice = allocator.mesh_vertex_slice(&caster.mesh);
            let (Some(slice), Some(mesh)) = (slice, meshes.get(caster.mesh)) else {
                return Ok(None);
            };
            let corner = caster.center - caster.half_extents;
            let opposite = caster.center + caster.half_extents;
            let index_slice = allocator.mesh_index_slice(&caster.mesh);
            let indices = match (&index_slice, mesh.index_format()) {
                (Some(slice), Some(format)) => Some(Indices {
                    buffer: slice.buffer,
                    format,
                }),
                _ => None,
            };
            let (range, base_vertex) = match index_slice {
                Some(indexed) => (indexed.range, slice.range.start as i32),
                None => (slice.range, 0),
            };
            // Add it to the set.
            let mesh = set.add_mesh(&CasterMesh {
                label: "mesh of Bevy's",
                vertices: slice.buffer,
                // Positions are the first attribute of Bevy's vertices.
                layout: VertexLayout {
                    format: PositionFormat::Float32x3,
                    stride: mesh.layout.0.layout().array_stride,
                    position_offset: 0,
                },
                indices,
                range,
                base_vertex,
                bounds: Aabb {
                    min: corner.to_array().into(),
                    max: opposite.to_array().into(),
                },
            })?;
            set.add_caster(mesh, affine(&caster.world_from_local))?;
        }
        let light = set.add_light(ShadowedLight {
            light: light_of(&sun),
            technique: Arc::clone(technique),
            priority: 1.0,
        })?;
        Ok(Some(Self {
            set,
            light,
            sun,
            casters: seen.casters.clone(),
            places,
        }))
    }
}

fn light_of(sun: &SeenSun) -> Light {
    Light::Directional {
        direction: sun.direction.to_array().into(),
        angular_diameter: sun.angular_diameter,
    }
}

/// Converts Bevy's matrices, which are of another version of the same crate.
fn affine(place: &GlobalTransform) -> glam::Affine3A {
    let matrix = place.to_matrix().to_cols_array();
    glam::Affine3A::from_mat4(glam::Mat4::from_cols_array(&matrix))
}

#[expect(
    clippy::too_many_arguments,
    reason = "a system of Bevy's names each resource"
)]
fn draw_masks(
    view: ViewQuery<(&ExtractedView, &ViewPrepassTextures)>,
    seen: Res<SeenScene>,
    mut shadows: ResMut<SunShadows>,
    meshes: Res<RenderAssets<RenderMesh>>,
    allocator: Res<MeshAllocator>,
    images: Res<RenderAssets<GpuImage>>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    mut ctx: RenderContext,
) -> Result {
    // Skip frames without a sun, a mask or a prepass.
    let (view, prepass) = view.into_inner();
    let (Some(sun), Some(mask)) = (seen.sun, seen.mask) else {
        return Ok(());
    };
    let (Some(depth), Some(normal)) = (prepass.depth_only_view(), prepass.normal_view()) else {
        return Ok(());
    };
    let Some(mask) = images.get(mask) else {
        return Ok(());
    };
    // Rebuild the set if casters, their buffers or the sun changed.
    let place = |caster: &SeenCaster| MeshPlace::of_mesh(&caster.mesh, &allocator);
    let places: Vec<MeshPlace> = seen.casters.iter().map(place).collect();
    let moved_buffers = allocator.meshes_displaced_by_slab_growth().next().is_some();
    let is_stale = shadows.made.as_ref().is_none_or(|made| {
        moved_buffers || made.casters != seen.casters || made.places != places || made.sun != sun
    });
    if is_stale {
        shadows.made = Made::new(
            &shadows.technique,
            &seen,
            sun,
            places,
            &meshes,
            &allocator,
            &device,
            &queue,
        )?;
    }
    let draws_all_again = shadows.draws_all_again;
    let Some(made) = &mut shadows.made else {
        return Ok(());
    };
    // Convert the camera.
    let world_from_view = affine(&view.world_from_view);
    let projection = view.clip_from_view.to_cols_array();
    let camera = Camera {
        world_from_view,
        clip_from_view: glam::Mat4::from_cols_array(&projection),
        size: glam::UVec2::new(view.viewport.z, view.viewport.w),
    };
    // Draw the mask, and copy it to the image that the material reads.
    let encoder = ctx.command_encoder();
    let texture = made.draw(
        &camera,
        draws_all_again,
        depth,
        normal,
        encoder,
    )?;
    encoder.copy_texture_to_texture(
        texture.as_image_copy(),
        mask.texture.as_image_copy(),
        wgpu::Extent3d {
            width: camera.size.x,
            height: camera.size.y,
            depth_or_array_layers: 1,
        },
    );
    Ok(())
}

impl Made {
    /// Records the passes for the camera's mask, and returns it.
    fn draw(
        &mut self,
        camera: &Camera,
        draws_all_again: bool,
        depth: &wgpu::TextureView,
        normal: &wgpu::TextureView,
        encoder: &mut wgpu::CommandEncoder,
    ) -> std::result::Result<wgpu::Texture, BackendError> {
        if draws_all_again {
            let everywhere = self.set.casters_box();
            self.set.touch(&everywhere)?;
        }
        let frame = SetFrame {
            camera,
            geometry: None,
        };
        self.set.prepare(&frame)?;
        self.set.encode(encoder)?;
        let view_from_world = glam::Mat4::from(camera.world_from_view.inverse());
        let clip_from_world = camera.clip_from_view * view_from_world;
        let inputs = MaskInputs {
            size: camera.size,
            receivers: MaskReceivers::Depth {
                depth: DepthBuffer {
                    depth,
                    world_from_clip: clip_from_world.inverse(),
                    // Bevy's depth is reversed.
                    empty: 0.0,
                },
                normals: Some(SetNormals {
                    texture: normal,
                    coding: NormalCoding::Halved,
                }),
            },
            lights: &[self.light],
            format: MaskFormat::Float32,
        };
        self.set.prepare_masks(&inputs)?;
        Ok(self.set.encode_masks(encoder)?.texture().clone())
    }
}
