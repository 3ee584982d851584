//! The plug-in: umbrage's shadows of the sun in Bevy's own 3D scenes.
//!
//! Between the prepass and the main pass a [`LightSet`] draws the maps from the vertex buffers that Bevy has, and a mask from Bevy's
//! depth and normals; the material reads the mask into `directional_shadow_factor`. Bevy multiplies that in only where the sun's own
//! shadow maps are on: so they are on, and nothing is drawn into them ([`NotShadowCaster`]).

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
    wgpu::{
        CasterMesh, DepthBuffer, LightId, LightSet, LightSetOptions, MaskFormat, MaskInputs,
        NormalCoding, PositionFormat, SetFrame, SetLight, SetNormals, SetReceivers, VertexLayout,
    },
};

/// A material that takes the sun's shadow from a mask.
pub type MaskedMaterial = ExtendedMaterial<StandardMaterial, ReadsMask>;

/// Adds shadows to all cameras with a [`MaskOf`].
pub struct UmbragePlugin {
    /// How the sun's shadows are made.
    pub technique: Arc<dyn ShadowTechnique>,
    /// Whether all maps are drawn in every frame, also where nothing moved: for those who time it.
    pub draws_all_again: bool,
}

/// Marks a mesh that casts.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(NotShadowCaster)]
pub struct Casts;

/// On a camera: the picture that takes its mask, `R32Float` of the camera's size, usage `COPY_DST`.
#[derive(Component, Clone, Debug)]
#[require(DepthPrepass, NormalPrepass)]
pub struct MaskOf(pub Handle<Image>);

/// What the material needs besides the standard one's.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct ReadsMask {
    /// The camera's mask.
    #[texture(100, sample_type = "float", filterable = false)]
    pub mask: Handle<Image>,
}

impl MaterialExtension for ReadsMask {
    fn fragment_shader() -> ShaderRef {
        "embedded://beside_bevy/mask.wesl".into()
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
            .insert_resource(Shadows {
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
            // `exact` has the device list the casters, from buffers that shaders read.
            let usage = bevy::render::render_resource::BufferUsages::STORAGE;
            let mut settings = render_app
                .world_mut()
                .get_resource_or_init::<MeshAllocatorSettings>();
            settings.extra_buffer_usages |= usage;
        }
    }
}

/// What casts in the main world, and the sun.
#[derive(Resource, Default)]
struct SeenScene {
    casters: Vec<SeenCaster>,
    direction: Option<Vec3>,
    mask: Option<AssetId<Image>>,
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
    suns: Extract<Query<(&DirectionalLight, &GlobalTransform)>>,
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
    let sun = suns.iter().find(|(sun, _)| sun.shadow_maps_enabled);
    seen.direction = sun.map(|(_, place)| place.forward().into());
    seen.mask = cameras.iter().next().map(|mask| mask.0.id());
}

/// The light set, and what it was made from.
#[derive(Resource)]
pub struct Shadows {
    technique: Arc<dyn ShadowTechnique>,
    draws_all_again: bool,
    made: Option<Made>,
}

struct Made {
    set: LightSet,
    light: LightId,
    direction: Vec3,
    casters: Vec<SeenCaster>,
    /// Where the vertices of each caster lie.
    places: Vec<Range<u32>>,
}

impl Shadows {
    /// Returns the bytes of maps and mask.
    pub fn bytes(&self, size: UVec2) -> u64 {
        let maps = self.made.as_ref().map_or(0, |made| made.set.map_bytes());
        // The mask, and the copy that the material reads.
        maps + 2 * 4 * u64::from(size.x) * u64::from(size.y)
    }
}

impl Made {
    /// Returns a set with one sun and all casters, whose triangles stay in Bevy's buffers; none while Bevy has not loaded them all.
    fn new(
        technique: &Arc<dyn ShadowTechnique>,
        seen: &SeenScene,
        direction: Vec3,
        places: Vec<Range<u32>>,
        meshes: &RenderAssets<RenderMesh>,
        allocator: &MeshAllocator,
        device: &RenderDevice,
    ) -> Result<Option<Self>, BackendError> {
        let mut set = LightSet::new(device.wgpu_device(), LightSetOptions::default())?;
        for caster in &seen.casters {
            let slice = allocator.mesh_vertex_slice(&caster.mesh);
            let (Some(slice), Some(mesh)) = (slice, meshes.get(caster.mesh)) else {
                return Ok(None);
            };
            let corner = caster.center - caster.half_extents;
            let opposite = caster.center + caster.half_extents;
            let mesh = set.add_mesh(&CasterMesh {
                label: "mesh of Bevy's",
                vertices: slice.buffer,
                // Positions are the first attribute of Bevy's vertices.
                layout: VertexLayout {
                    format: PositionFormat::Float32x3,
                    stride: mesh.layout.0.layout().array_stride,
                    position_offset: 0,
                },
                indices: None,
                range: slice.range.clone(),
                base_vertex: 0,
                bounds: Aabb {
                    min: corner.to_array().into(),
                    max: opposite.to_array().into(),
                },
            })?;
            set.add_caster(mesh, affine(&caster.world_from_local))?;
        }
        let light = set.add_light(SetLight {
            light: sun(direction),
            technique: Arc::clone(technique),
            priority: 1.0,
        })?;
        Ok(Some(Self {
            set,
            light,
            direction,
            casters: seen.casters.clone(),
            places,
        }))
    }
}

fn sun(direction: Vec3) -> Light {
    Light::Directional {
        direction: direction.to_array().into(),
        angular_diameter: 0.0,
    }
}

/// Bevy's matrices are of another version of the same crate.
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
    mut shadows: ResMut<Shadows>,
    meshes: Res<RenderAssets<RenderMesh>>,
    allocator: Res<MeshAllocator>,
    images: Res<RenderAssets<GpuImage>>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    mut ctx: RenderContext,
) {
    let (view, prepass) = view.into_inner();
    let (Some(direction), Some(mask)) = (seen.direction, seen.mask) else {
        return;
    };
    let (Some(depth), Some(normal)) = (prepass.depth_only_view(), prepass.normal_view()) else {
        return;
    };
    let Some(mask) = images.get(mask) else {
        return;
    };
    let place = |caster: &SeenCaster| {
        let slice = allocator.mesh_vertex_slice(&caster.mesh);
        slice.map_or(0..0, |slice| slice.range)
    };
    let places: Vec<Range<u32>> = seen.casters.iter().map(place).collect();
    let moved_buffers = allocator.meshes_displaced_by_slab_growth().next().is_some();
    let is_stale = shadows.made.as_ref().is_none_or(|made| {
        moved_buffers
            || made.casters != seen.casters
            || made.places != places
            || made.direction != direction
    });
    if is_stale {
        let made = Made::new(
            &shadows.technique,
            &seen,
            direction,
            places,
            &meshes,
            &allocator,
            &device,
        );
        shadows.made = made.expect("meshes can be drawn from Bevy's buffers");
    }
    let draws_all_again = shadows.draws_all_again;
    let Some(made) = &mut shadows.made else {
        return;
    };
    let world_from_view = affine(&view.world_from_view);
    let projection = view.clip_from_view.to_cols_array();
    let camera = Camera {
        world_from_view,
        clip_from_view: glam::Mat4::from_cols_array(&projection),
        size: glam::UVec2::new(view.viewport.z, view.viewport.w),
    };
    let encoder = ctx.command_encoder();
    let drawn = made.draw(
        &camera,
        draws_all_again,
        depth,
        normal,
        &device,
        &queue,
        encoder,
    );
    let texture = drawn.expect("the mask can be drawn");
    encoder.copy_texture_to_texture(
        texture.as_image_copy(),
        mask.texture.as_image_copy(),
        wgpu::Extent3d {
            width: camera.size.x,
            height: camera.size.y,
            depth_or_array_layers: 1,
        },
    );
}

impl Made {
    /// Records what the camera's mask needs, and returns it.
    #[expect(
        clippy::too_many_arguments,
        reason = "what a frame of the caller's is made of"
    )]
    fn draw(
        &mut self,
        camera: &Camera,
        draws_all_again: bool,
        depth: &wgpu::TextureView,
        normal: &wgpu::TextureView,
        device: &RenderDevice,
        queue: &RenderQueue,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<wgpu::Texture, BackendError> {
        if draws_all_again {
            let everywhere = self.set.casters_box();
            self.set.touch(&everywhere)?;
        }
        let frame = SetFrame {
            camera,
            geometry: None,
        };
        self.set.prepare(device.wgpu_device(), queue, &frame)?;
        self.set.encode(encoder)?;
        let view_from_world = glam::Mat4::from(camera.world_from_view.inverse());
        let clip_from_world = camera.clip_from_view * view_from_world;
        let inputs = MaskInputs {
            size: camera.size,
            receivers: SetReceivers::Depth {
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
        self.set.prepare_masks(queue, &inputs)?;
        Ok(self.set.encode_masks(encoder)?.texture().clone())
    }
}
