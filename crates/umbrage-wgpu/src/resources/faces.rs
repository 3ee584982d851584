//! Faces that techniques made, on the GPU.

use crate::resources::counters::ResourceFactory;
use std::sync::Arc;
use umbrage_core::{Faces, Invalid, Recipe, Source};
use wgpu::{Buffer, BufferUsages};

/// Faces that were uploaded, by their address. Holding them keeps addresses from being used again for others.
#[derive(Debug, Default)]
pub(crate) struct FaceBuffers {
    held: Vec<RendererState>,
    /// Of faces that no recipe can name any more: a technique that makes new faces each frame needs no new buffers.
    spare: Vec<[Buffer; 2]>,
}

#[derive(Debug)]
struct RendererState {
    faces: Arc<Faces>,
    buffers: [Buffer; 2],
}

impl FaceBuffers {
    /// Vertices and indices.
    pub(crate) fn get(
        &mut self,
        maker: &mut ResourceFactory<'_>,
        faces: &Arc<Faces>,
    ) -> [Buffer; 2] {
        if let Some(held) = self
            .held
            .iter()
            .find(|held| Arc::ptr_eq(&held.faces, faces))
        {
            return held.buffers.clone();
        }
        let (vertices, indices) = bytes(faces);
        let fits = |[v, i]: &[Buffer; 2]| {
            v.size() >= vertices.len() as u64 && i.size() >= indices.len() as u64
        };
        let spare = self
            .spare
            .iter()
            .position(fits)
            .map(|i| self.spare.swap_remove(i));
        let [mut v, mut i] = spare.map_or([None, None], |buffers| buffers.map(Some));
        let buffers = [
            maker.write(
                &mut v,
                "umbrage faces' vertices",
                BufferUsages::VERTEX,
                vertices,
            ),
            maker.write(
                &mut i,
                "umbrage faces' triangles",
                BufferUsages::INDEX,
                indices,
            ),
        ];
        self.held.push(RendererState {
            faces: faces.clone(),
            buffers: buffers.clone(),
        });
        buffers
    }

    /// Lets go of faces that nobody else holds: no recipe can name them any more.
    pub(crate) fn forget_unreachable(&mut self) {
        self.spare.clear();
        let gone = self
            .held
            .extract_if(.., |held| Arc::strong_count(&held.faces) == 1);
        self.spare.extend(gone.map(|held| held.buffers));
    }
}

fn bytes(faces: &Faces) -> (&[u8], &[u8]) {
    (
        bytemuck::cast_slice(&faces.vertices),
        bytemuck::cast_slice(&faces.triangles),
    )
}

/// Objects to faces that no buffer of `most` bytes holds.
pub(crate) fn check_faces(recipe: &Recipe, most: u64) -> Result<(), Invalid> {
    for cast in &recipe.casts {
        let Source::Faces(faces) = &cast.source else {
            continue;
        };
        let (vertices, indices) = bytes(faces);
        let bytes = vertices.len().max(indices.len()) as u64;
        // Buffers grow to powers of two.
        if bytes.next_power_of_two() > most {
            let why = format!(
                "take {bytes} bytes, and this graphics adapter holds at most {most} in one buffer"
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
