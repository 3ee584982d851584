//! The passes of a frame: the layers that it redraws, and the draws into each.

use crate::{
    cast::CastBindings,
    light_set::{
        casters::Casters,
        culling::{ShownSlots, Wanted},
        ids::{LightKey, MeshKey, OwnCasterId, SetNumber},
        options::StillLayers,
        prices::Prices,
        state::{HeldLight, LightCast, LightMaps, StillLayer},
        still_layers,
        timestamps::{PassCasters, PassClock},
    },
    resources::{
        counters::ResourceFactory,
        cut_outs::GpuCutOuts,
        images::extent,
        pipelines::{Pipelines, Vertex},
    },
    targets::CastTarget,
};
use slotmap::SlotMap;
use std::ops::Range;
use wgpu::{CommandEncoder, RenderPass, RenderPassDescriptor, RenderPipeline};

/// Draws the program's casters with these ids into a target.
pub(crate) type OwnDraws<'a> = &'a mut dyn FnMut(&mut RenderPass<'_>, &CastTarget, &[OwnCasterId]);

/// The cast drawn by a pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassName {
    pub(crate) light: LightKey,
    /// Index among the light's casts.
    pub(crate) cast: usize,
    pub(crate) part: PassCasters,
}

/// Inputs for the selection and recording of passes.
#[derive(Debug)]
pub(crate) struct CastSources<'a> {
    pub(crate) set: SetNumber,
    pub(crate) casters: &'a Casters,
    pub(crate) option: StillLayers,
    pub(crate) prices: &'a Prices,
    /// Bytes left for new layers of still casters.
    pub(crate) bytes_left: u64,
}

/// One pass of this frame.
#[derive(Debug)]
struct CastPass {
    name: PassName,
    /// Range in the list of draws.
    draws: Range<usize>,
    /// Range in the list of the program's casters.
    own: Range<usize>,
    /// Number of triangles.
    triangles: u64,
}

/// The draws of a mesh.
#[derive(Debug)]
struct MeshDraws {
    mesh: MeshKey,
    pipeline: RenderPipeline,
    /// Range in the list of runs.
    runs: Range<usize>,
}

/// The passes of a frame. The lists keep their memory between frames.
#[derive(Debug, Default)]
pub(crate) struct PassList {
    /// The lights whose uniforms or layers change in this frame.
    pub(crate) lights: Vec<LightKey>,
    passes: Vec<CastPass>,
    draws: Vec<MeshDraws>,
    /// Runs of slots.
    runs: Vec<Range<u32>>,
    /// The casters that the program draws.
    own: Vec<OwnCasterId>,
    /// Scratch: the slots visible in a layer.
    shown: ShownSlots,
    bindings: CastBindings,
}

impl PassList {
    pub(crate) fn clear(&mut self) {
        self.lights.clear();
        self.passes.clear();
        self.draws.clear();
        self.runs.clear();
        self.own.clear();
    }

    /// Removes a caster that the program no longer draws.
    pub(crate) fn forget_own(&mut self, removed: OwnCasterId) {
        for pass in &mut self.passes {
            let shown = &mut self.own[pass.own.clone()];
            if let Some(i) = shown.iter().position(|&id| id == removed) {
                shown[i..].rotate_left(1);
                pass.own.end -= 1;
            }
        }
    }

    /// Appends the passes that redraw the changed layers of a light.
    pub(crate) fn push_light(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &mut CastSources<'_>,
        light: LightKey,
        maps: &mut LightMaps,
    ) {
        let may_split = maps.may_split();
        for (index, cast) in maps.casts.iter_mut().enumerate() {
            if !cast.is_stale {
                continue;
            }
            cast.volume.find(sources.casters.boxes(), &mut self.shown);
            let has_own = sources
                .casters
                .own()
                .shown_in(&cast.volume)
                .next()
                .is_some();
            let CastSources {
                casters,
                option,
                prices,
                ..
            } = *sources;
            let splits = may_split
                && still_layers::is_wanted(option, prices, casters, cast, &self.shown, has_own)
                && has_still_layer(factory, cast, &mut sources.bytes_left);
            if !splits {
                cast.still = None;
            }
            let parts: &[PassCasters] = match &cast.still {
                None => &[PassCasters::All],
                Some(still) if !still.is_stale => &[PassCasters::Moving],
                Some(_) => &[PassCasters::Still, PassCasters::Moving],
            };
            for &part in parts {
                let name = PassName {
                    light,
                    cast: index,
                    part,
                };
                self.push(factory, pipelines, sources, cast, name);
            }
        }
    }

    /// Appends a pass that draws a cast of a light: its visible casters, or a part of them.
    fn push(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &CastSources<'_>,
        cast: &LightCast,
        name: PassName,
    ) {
        let moving = sources.casters.moving_flags();
        let wanted = match name.part {
            PassCasters::All => Wanted::All,
            PassCasters::Still => Wanted::Still(moving),
            PassCasters::Moving => Wanted::Moving(moving),
        };
        let first_draw = self.draws.len();
        // Append a draw for each mesh with visible casters.
        let mut triangles = 0;
        for (id, mesh) in sources.casters.meshes() {
            let first_run = self.runs.len();
            self.shown.runs(mesh.slots(), wanted, &mut self.runs);
            let runs = first_run..self.runs.len();
            if runs.is_empty() {
                continue;
            }
            let instances: u64 = self.runs[runs.clone()]
                .iter()
                .map(|run| u64::from(run.end - run.start))
                .sum();
            triangles += instances * mesh.draw.triangles();
            let vertex = match mesh.draw.holes {
                Some(rule) => Vertex::CutOut(rule),
                None => Vertex::Instanced,
            };
            self.draws.push(MeshDraws {
                mesh: id,
                pipeline: pipelines.cast(factory, &cast.target, mesh.draw.layout, vertex),
                runs,
            });
        }
        // The program's casters count as moving.
        let first_own = self.own.len();
        if name.part != PassCasters::Still {
            let shown = sources.casters.own().shown_in(&cast.volume);
            self.own
                .extend(shown.map(|key| OwnCasterId::new(sources.set, key)));
        }
        self.passes.push(CastPass {
            name,
            draws: first_draw..self.draws.len(),
            own: first_own..self.own.len(),
            triangles,
        });
    }

    /// Writes the inputs of the passes. Returns the number of written bytes.
    pub(crate) fn upload(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        lights: &SlotMap<LightKey, HeldLight>,
        holes: Option<&GpuCutOuts>,
    ) -> u64 {
        let passes = self.passes.iter();
        let targets = passes.map(|pass| &lights[pass.name.light].maps.casts[pass.name.cast].target);
        self.bindings.write(factory, pipelines, targets, holes)
    }

    /// Returns the number of passes.
    pub(crate) fn count(&self) -> usize {
        self.passes.len()
    }

    /// Returns the casts drawn by the passes.
    pub(crate) fn names(&self) -> impl Iterator<Item = PassName> + '_ {
        self.passes.iter().map(|pass| pass.name)
    }

    /// Records a cast; `own_draws` draws the program's casters in the same pass.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        pass_index: usize,
        cast: &LightCast,
        casters: &Casters,
        own_draws: OwnDraws<'_>,
        clock: &mut PassClock<'_, '_>,
    ) {
        let CastPass {
            name,
            draws,
            own,
            triangles,
        } = &self.passes[pass_index];
        let part = name.part;
        // Copy the still casters.
        if let (PassCasters::Moving, Some(still)) = (part, &cast.still) {
            let texels = u64::from(cast.target.size.x) * u64::from(cast.target.size.y);
            let copy = |encoder: &mut CommandEncoder| copy_still_layer(encoder, still, cast);
            match &mut clock.meter {
                Some(meter) => meter.copy(encoder, texels, copy),
                None => copy(encoder),
            }
        }
        // Begin the pass.
        let target = match (part, &cast.still) {
            (PassCasters::Still, Some(still)) => &still.target,
            _ => &cast.target,
        };
        let clears = target.clears && part != PassCasters::Moving;
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("umbrage cast"),
            depth_stencil_attachment: Some(target.attachment_that(clears)),
            timestamp_writes: clock.cast(name.light, cast.layer, part, *triangles),
            ..RenderPassDescriptor::default()
        });
        self.bindings.bind(&mut pass, pass_index, &cast.peeled);
        if let Some(buffer) = casters.instances.buffer() {
            pass.set_vertex_buffer(1, buffer.slice(..));
        }
        // Draw the meshes.
        let mut last = None;
        for draws in &self.draws[draws.clone()] {
            let Some(mesh) = casters.mesh(draws.mesh) else {
                continue;
            };
            if last != Some(&draws.pipeline) {
                pass.set_pipeline(&draws.pipeline);
                last = Some(&draws.pipeline);
            }
            if mesh.holes.is_some() {
                self.bindings.bind_holes(&mut pass, pass_index);
            }
            mesh.bind(&mut pass);
            for run in &self.runs[draws.runs.clone()] {
                mesh.draw(&mut pass, run.clone());
            }
        }
        if !own.is_empty() {
            own_draws(&mut pass, &cast.target, &self.own[own.clone()]);
        }
    }
}

/// Records a copy of the layer of still casters into the cast's layer.
fn copy_still_layer(encoder: &mut CommandEncoder, still: &StillLayer, cast: &LightCast) {
    let mut to = cast.target.layer.texture().as_image_copy();
    to.origin.z = cast.texture_layer;
    let from = still.texture.as_image_copy();
    encoder.copy_texture_to_texture(from, to, extent(cast.target.size, 1));
}

/// Returns whether a cast has a layer for the still casters. Creates one if it fits into the
/// remaining bytes.
fn has_still_layer(
    factory: &mut ResourceFactory<'_>,
    cast: &mut LightCast,
    bytes_left: &mut u64,
) -> bool {
    if cast.still.is_some() {
        return true;
    }
    let bytes = still_layers::bytes_of(&cast.target);
    if bytes > *bytes_left {
        return false;
    }
    *bytes_left -= bytes;
    cast.still = Some(StillLayer::like_target(factory, &cast.target));
    true
}
