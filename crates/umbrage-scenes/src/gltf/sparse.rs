//! Sparse accessors: elements that stand in place of others.

use super::{
    accessor::{ElementFormat, check_end, u16_of, u32_of},
    broken,
    budget::ReadBudget,
    buffers::{Buffers, ViewBytes},
};
use gltf::accessor::sparse::{IndexType, Sparse as FileSparse};
use umbrage_core::Invalid;

/// The elements, all of whose bytes are there.
#[derive(Debug)]
pub(super) struct Sparse<'a> {
    /// Which elements of the accessor they replace.
    at: Vec<u32>,
    values: ViewBytes<'a>,
    start: usize,
    /// Bytes of an element.
    size: usize,
}

impl<'a> Sparse<'a> {
    /// Looks up what replaces elements of an accessor with so many.
    pub(super) fn open(
        sparse: &FileSparse<'_>,
        format: ElementFormat,
        elements: usize,
        buffers: &mut Buffers<'a>,
        budget: &mut ReadBudget,
    ) -> Result<Self, Invalid> {
        let count = sparse.count();
        if count > elements {
            let why = format!("replaces {count} of {elements} elements");
            return Err(broken("sparse", why));
        }
        budget.read(count as u64)?;
        let at = indices(sparse, buffers, budget).map_err(|e| e.within("sparse indices"))?;
        if let Some(beyond) = at.iter().find(|&&i| i as usize >= elements) {
            let why = format!("hold {beyond}, of {elements} elements");
            return Err(broken("sparse indices", why));
        }
        let size = format.size();
        let values = sparse.values();
        let start = values.offset();
        let bytes = buffers
            .view(&values.view(), budget)
            .and_then(|bytes| {
                check_end(&bytes, start, size, size, count)?;
                Ok(bytes)
            })
            .map_err(|e| e.within("sparse values"))?;
        Ok(Self {
            at,
            values: bytes,
            start,
            size,
        })
    }

    /// Returns which elements are replaced, and the bytes of those in their place.
    pub(super) fn elements(&self) -> impl Iterator<Item = (u32, &[u8])> {
        let bytes = self.values.slice().get(self.start..).unwrap_or(&[]);
        self.at.iter().copied().zip(bytes.chunks_exact(self.size))
    }
}

fn indices(
    sparse: &FileSparse<'_>,
    buffers: &mut Buffers<'_>,
    budget: &mut ReadBudget,
) -> Result<Vec<u32>, Invalid> {
    let indices = sparse.indices();
    let kind = indices.index_type();
    let size = kind.size();
    let start = indices.offset();
    let bytes = buffers.view(&indices.view(), budget)?;
    check_end(&bytes, start, size, size, sparse.count())?;
    let index = |bytes: &[u8]| match kind {
        IndexType::U8 => u32::from(bytes[0]),
        IndexType::U16 => u32::from(u16_of(bytes)),
        IndexType::U32 => u32_of(bytes),
    };
    let bytes = bytes.slice().get(start..).unwrap_or(&[]);
    Ok(bytes
        .chunks_exact(size)
        .take(sparse.count())
        .map(index)
        .collect())
}
