//! The layers that a frame redraws, and what is drawn into each.

use crate::{
    cast::Layouts,
    light_set::{
        buffers::Uploaded,
        casters::{Casters, Columns, MeshId},
        culling::{ShownSlots, Wanted},
        light::{LightCast, LightId},
        still_layers::LayerCopy,
        timestamps::{PassCasters, PassClock},
    },
    resources::{
        counters::ResourceFactory,
        cut_outs::{CutOutBinding, GpuCutOuts, cut_out_layout},
        draws::Vertex,
        images::extent,
        matrices::Matrices,
        pipelines::{CastKey, Peel, Pipelines},
    },
    targets::CastTarget,
};
use glam::Mat4;
use std::ops::Range;
use umbrage_core::CameraRays;
use wgpu::{
    Buffer, BufferUsages, CommandEncoder, RenderPass, RenderPassDescriptor, RenderPipeline,
};

/// Unchanged instances between changed ones that are written along: a write of its own takes about as long as 12 kB more of another.
const GREATEST_GAP: u32 = 256;

/// Casts read instances as vertices, and what lists casters as a table.
const INSTANCES: BufferUsages = BufferUsages::VERTEX.union(BufferUsages::STORAGE);

/// World from local of all slots, as vertex shaders read it.
#[derive(Debug, Default)]
pub(crate) struct Instances(Option<Buffer>);

impl Instances {
    /// Writes what changed; all of it into a greater buffer where it doesn't fit.
    pub(crate) fn upload(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        casters: &mut Casters,
    ) -> Uploaded {
        const STRIDE: u64 = size_of::<Columns>() as u64;
        let mut uploaded = Uploaded::default();
        let (columns, written) = casters.written();
        if columns.is_empty() {
            return uploaded;
        }
        let size = columns.len() as u64 * STRIDE;
        if self.0.as_ref().map_or(0, Buffer::size) < size {
            let room = size.next_power_of_two();
            let buffer = factory.buffer("umbrage instances", INSTANCES, room);
            factory
                .queue
                .write_buffer(&buffer, 0, bytemuck::cast_slice(columns));
            self.0 = Some(buffer);
            uploaded.bytes = size;
            return uploaded;
        }
        let Some(buffer) = &self.0 else {
            return uploaded;
        };
        let mut rest = written;
        while let Some(&first) = rest.first() {
            let count = run_length(rest);
            let last = rest[count - 1];
            let bytes: &[u8] = bytemuck::cast_slice(&columns[first as usize..=last as usize]);
            factory
                .queue
                .write_buffer(buffer, u64::from(first) * STRIDE, bytes);
            uploaded.bytes += bytes.len() as u64;
            rest = &rest[count..];
        }
        uploaded
    }

    pub(crate) fn buffer(&self) -> Option<&Buffer> {
        self.0.as_ref()
    }

    /// Forgets the buffer: the next upload makes and fills another.
    pub(crate) fn lose_buffer(&mut self) {
        self.0 = None;
    }
}

/// Returns how many of these rising slots are written together.
fn run_length(slots: &[u32]) -> usize {
    let is_gap = |pair: &[u32]| pair[1] - pair[0] > GREATEST_GAP;
    let end = slots.windows(2).position(is_gap);
    end.map_or(slots.len(), |i| i + 1)
}

/// Which cast of which light a pass draws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassName {
    pub(crate) light: LightId,
    /// Index among the light's casts.
    pub(crate) cast: usize,
    pub(crate) part: PassCasters,
}

/// What passes draw from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CastSources<'a> {
    pub(crate) layouts: &'a Layouts,
    pub(crate) casters: &'a Casters,
    /// The slots that show in the cast's layer.
    pub(crate) shown: &'a ShownSlots,
}

/// A cast, and what is drawn into it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DrawnCast<'a> {
    pub(crate) cast: &'a LightCast,
    pub(crate) casters: &'a Casters,
    pub(crate) instances: &'a Instances,
}

/// One pass of this frame.
#[derive(Debug)]
struct CastPass {
    name: PassName,
    /// What is copied first.
    copy: Option<LayerCopy>,
    /// Its part of the list of draws.
    draws: Range<usize>,
    /// How many triangles it draws.
    triangles: u64,
}

/// What is drawn of a mesh.
#[derive(Debug)]
struct MeshDraws {
    mesh: MeshId,
    pipeline: RenderPipeline,
    /// Its part of the list of runs.
    runs: Range<usize>,
}

/// The casts of a frame. Its lists keep their memory from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct CastList {
    passes: Vec<CastPass>,
    draws: Vec<MeshDraws>,
    /// Runs of slots.
    runs: Vec<Range<u32>>,
    spaces: Matrices,
    matrices: Vec<Mat4>,
    /// What draws of triangles with holes read; each pass's rays.
    holes: CutOutBinding,
    /// Of each pass, where there are triangles with holes.
    rays: Vec<CameraRays>,
}

impl CastList {
    pub(crate) fn clear(&mut self) {
        self.passes.clear();
        self.draws.clear();
        self.runs.clear();
        self.matrices.clear();
        self.rays.clear();
    }

    /// Appends a pass that draws a cast of a light: the casters that show in it, or a part of them.
    pub(crate) fn push(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &CastSources<'_>,
        cast: &LightCast,
        name: PassName,
    ) {
        let moving = sources.casters.moving();
        let wanted = match name.part {
            PassCasters::All => Wanted::All,
            PassCasters::Still => Wanted::Still(moving),
            PassCasters::Moving => Wanted::Moving(moving),
        };
        let first_draw = self.draws.len();
        let mut triangles = 0;
        for (id, mesh) in sources.casters.meshes() {
            let first_run = self.runs.len();
            sources.shown.runs(mesh.slots(), wanted, &mut self.runs);
            let runs = first_run..self.runs.len();
            if runs.is_empty() {
                continue;
            }
            let instances: u64 = self.runs[runs.clone()]
                .iter()
                .map(|run| u64::from(run.end - run.start))
                .sum();
            triangles += instances * mesh.draw.triangles();
            let key = CastKey {
                depth: cast.target.state(),
                layout: mesh.draw.layout,
                vertex: match mesh.draw.holes {
                    Some(rule) => Vertex::CutOut(rule),
                    None => Vertex::Instanced,
                },
                peel: Peel::of(&cast.target),
            };
            self.draws.push(MeshDraws {
                mesh: id,
                pipeline: pipelines.cast(factory, key, &sources.layouts.of(&key)),
                runs,
            });
        }
        self.matrices.push(cast.target.clip_from_world);
        if sources.layouts.cut_outs.is_some() {
            self.rays.push(cast.target.rays());
        }
        self.passes.push(CastPass {
            name,
            copy: layer_copy(cast, name.part),
            draws: first_draw..self.draws.len(),
            triangles,
        });
    }

    /// Writes the casts' matrices, and what tells holes where there are any.
    pub(crate) fn upload(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        holes: Option<&GpuCutOuts>,
    ) {
        self.spaces
            .write(factory, pipelines, self.matrices.iter().copied());
        if let Some(holes) = holes {
            let layout = cut_out_layout(factory, pipelines, holes.rule());
            let rays = self.rays.iter().copied();
            self.holes.write(factory, &layout, holes, rays);
        }
    }

    /// Returns how many casts there are.
    pub(crate) fn count(&self) -> usize {
        self.passes.len()
    }

    /// Returns which casts the passes draw.
    pub(crate) fn names(&self) -> impl Iterator<Item = PassName> + '_ {
        self.passes.iter().map(|pass| pass.name)
    }

    /// Records a cast; `own_draws` draws what the caller draws itself, in the same pass.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        pass_index: usize,
        drawn: &DrawnCast<'_>,
        own_draws: &mut dyn FnMut(&mut RenderPass<'_>, &CastTarget),
        clock: &mut PassClock<'_, '_>,
    ) {
        let DrawnCast {
            cast,
            casters,
            instances,
        } = *drawn;
        let CastPass {
            name,
            copy,
            triangles,
            ..
        } = &self.passes[pass_index];
        let part = name.part;
        if let Some(copy) = copy {
            let texels = u64::from(cast.target.size.x) * u64::from(cast.target.size.y);
            let record = |encoder: &mut CommandEncoder| copy.encode(encoder, &cast.target);
            match &mut clock.meter {
                Some(meter) => meter.copy(encoder, texels, record),
                None => record(encoder),
            }
        }
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
        self.spaces.bind(&mut pass, 0, pass_index);
        if cast.target.behind.is_some() {
            pass.set_bind_group(2, cast.peeled.group(), &[]);
        }
        if let Some(buffer) = &instances.0 {
            pass.set_vertex_buffer(1, buffer.slice(..));
        }
        let mut last = None;
        for draws in &self.draws[self.passes[pass_index].draws.clone()] {
            let Some(mesh) = casters.mesh(draws.mesh) else {
                continue;
            };
            if last != Some(&draws.pipeline) {
                pass.set_pipeline(&draws.pipeline);
                last = Some(&draws.pipeline);
            }
            if mesh.holes.is_some() {
                self.holes.bind(&mut pass, 1, pass_index);
            }
            mesh.bind(&mut pass);
            for run in &self.runs[draws.runs.clone()] {
                mesh.draw(&mut pass, run.clone());
            }
        }
        // What the caller draws belongs to what moves.
        if part != PassCasters::Still {
            own_draws(&mut pass, &cast.target);
        }
    }
}

/// Returns what is copied before a part of a cast is drawn.
fn layer_copy(cast: &LightCast, part: PassCasters) -> Option<LayerCopy> {
    let still = cast.still.as_ref()?;
    (part == PassCasters::Moving).then(|| LayerCopy {
        from: still.texture.clone(),
        to: cast.target.layer.texture().clone(),
        layer: cast.texture_layer,
    })
}

impl LayerCopy {
    fn encode(&self, encoder: &mut CommandEncoder, target: &CastTarget) {
        let mut to = self.to.as_image_copy();
        to.origin.z = self.layer;
        encoder.copy_texture_to_texture(self.from.as_image_copy(), to, extent(target.size, 1));
    }
}

#[cfg(test)]
mod tests {
    use super::run_length;

    #[test]
    fn near_slots_are_written_together() {
        assert_eq!(run_length(&[3]), 1);
        assert_eq!(run_length(&[3, 4, 9, 40, 400]), 4);
        assert_eq!(run_length(&[3, 300, 301]), 1, "a gap of 297");
    }
}
