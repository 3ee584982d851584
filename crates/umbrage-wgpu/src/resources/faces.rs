//! A technique's faces on the GPU.

use crate::resources::counters::ResourceFactory;
use std::sync::Arc;
use umbrage_core::{Faces, Invalid, Recipe, Source};
use wgpu::{Buffer, BufferUsages};

/// Uploaded faces, by their address. The faces are kept alive, so that their addresses are not
/// reused.
#[derive(Debug, Default)]
pub(crate) struct FaceBuffers {
    uploaded: Vec<UploadedFaces>,
    /// Buffers of faces that no recipe can refer to any more, for reuse by techniques that compute
    /// new faces each frame.
    spare: Vec<FaceBuffer>,
}

#[derive(Debug)]
struct UploadedFaces {
    faces: Arc<Faces>,
    buffer: FaceBuffer,
}

/// One set of faces on the GPU.
#[derive(Clone, Debug)]
pub(crate) struct FaceBuffer {
    pub(crate) vertices: Buffer,
    pub(crate) indices: Buffer,
}

impl FaceBuffers {
    /// Returns the faces' buffers; uploads new faces.
    pub(crate) fn get(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        faces: &Arc<Faces>,
    ) -> FaceBuffer {
        // Return cached buffers.
        for uploaded in &self.uploaded {
            if Arc::ptr_eq(&uploaded.faces, faces) {
                return uploaded.buffer.clone();
            }
        }
        // Find spare buffers that are large enough.
        let vertices = vertex_bytes(faces);
        let indices = index_bytes(faces);
        let fitting = self.spare.iter().position(|spare| {
            spare.vertices.size() >= vertices.len() as u64
                && spare.indices.size() >= indices.len() as u64
        });
        let mut spare_vertices = None;
        let mut spare_indices = None;
        if let Some(i) = fitting {
            let spare = self.spare.swap_remove(i);
            spare_vertices = Some(spare.vertices);
            spare_indices = Some(spare.indices);
        }
        // Upload the faces.
        let buffer = FaceBuffer {
            vertices: factory.write(
                &mut spare_vertices,
                "umbrage faces' vertices",
                BufferUsages::VERTEX,
                vertices,
            ),
            indices: factory.write(
                &mut spare_indices,
                "umbrage faces' triangles",
                BufferUsages::INDEX,
                indices,
            ),
        };
        self.uploaded.push(UploadedFaces {
            faces: faces.clone(),
            buffer: buffer.clone(),
        });
        buffer
    }

    /// Drops faces without other owners, since no recipe can refer to them any more. Their buffers
    /// become spare.
    pub(crate) fn forget_unreachable(&mut self) {
        self.spare.clear();
        let unreachable = self
            .uploaded
            .extract_if(.., |uploaded| Arc::strong_count(&uploaded.faces) == 1);
        self.spare.extend(unreachable.map(|faces| faces.buffer));
    }
}

fn vertex_bytes(faces: &Faces) -> &[u8] {
    bytemuck::cast_slice(&faces.vertices)
}

fn index_bytes(faces: &Faces) -> &[u8] {
    bytemuck::cast_slice(&faces.triangles)
}

/// Errors if the buffer of some faces would need more than `most` bytes.
pub(crate) fn check_faces(recipe: &Recipe, most: u64) -> Result<(), Invalid> {
    for cast in &recipe.casts {
        let Source::Faces(faces) = &cast.source else {
            continue;
        };
        let longer = vertex_bytes(faces).len().max(index_bytes(faces).len());
        let bytes = longer as u64;
        // Buffers grow to powers of two.
        if bytes.next_power_of_two() > most {
            let why = format!(
                "take {bytes} bytes, and this graphics adapter supports at most {most} in one buffer"
            );
            return Err(Invalid::new(
                "faces of a cast",
                why,
                "use a smaller scene or the CPU backend",
            ));
        }
    }
    Ok(())
}
