//! Numbers of accessors. The crate `gltf` reads them only after the checks here, since it panics on
//! some files.

use super::{
    document::{broken_element, element_name},
    file_bytes::FileBytes,
};
use gltf::accessor::{Accessor, DataType, Dimensions, Item, Iter, sparse::Sparse};
use umbrage_core::Invalid;

/// An accessor whose bytes are complete.
#[derive(Debug)]
pub(super) struct AccessorNumbers<'a> {
    accessor: Accessor<'a>,
    /// Name of the accessor in errors.
    name: String,
}

impl<'a> AccessorNumbers<'a> {
    /// Fetches and checks the bytes of an accessor, without reading elements.
    pub(super) fn open(accessor: Accessor<'a>, data: &mut FileBytes<'_>) -> Result<Self, Invalid> {
        let name = element_name("accessor", accessor.index(), accessor.name());
        check(&accessor, data).map_err(|e| e.within_context(&name))?;
        Ok(Self { accessor, name })
    }

    pub(super) fn count(&self) -> usize {
        self.accessor.count()
    }

    /// Reports whether the accessor has no bytes, which means zeros.
    pub(super) fn is_without_bytes(&self) -> bool {
        self.accessor.view().is_none() && self.accessor.sparse().is_none()
    }

    /// Returns the error of an accessor that is unsuitable for its use.
    pub(super) fn fault(&self, why: impl Into<String>) -> Invalid {
        broken_element(self.name.as_str(), why)
    }

    /// Returns indices of vertices.
    pub(super) fn indices(&self, data: &mut FileBytes<'_>) -> Result<Vec<u32>, Invalid> {
        let kind = self.accessor.data_type();
        let is_index = matches!(kind, DataType::U8 | DataType::U16 | DataType::U32);
        if !is_index || self.accessor.dimensions() != Dimensions::Scalar {
            return Err(self.fault("holds no indices: indices are unsigned scalars"));
        }
        data.budget.read(self.count() as u64)?;
        Ok(match kind {
            DataType::U8 => self.read::<u8>(None, data).map(u32::from).collect(),
            DataType::U16 => self.read::<u16>(None, data).map(u32::from).collect(),
            _ => self.read::<u32>(None, data).collect(),
        })
    }

    /// Returns vectors as 32-bit floats: the elements with these ascending indices, or all. Returns
    /// an error if they have another length or are not finite.
    pub(super) fn vectors<const N: usize>(
        &self,
        these: Option<&[u32]>,
        data: &mut FileBytes<'_>,
    ) -> Result<Vec<[f32; N]>, Invalid> {
        let is_vector = matches!(
            self.accessor.dimensions(),
            Dimensions::Vec2 | Dimensions::Vec3 | Dimensions::Vec4
        );
        if !is_vector || self.accessor.dimensions().multiplicity() != N {
            return Err(self.fault(format!("holds no vectors of {N} numbers")));
        }
        data.budget
            .read(these.map_or(self.count(), <[u32]>::len) as u64)?;
        let vectors = match self.accessor.data_type() {
            DataType::F32 => self
                .read::<Vector<f32, N>>(these, data)
                .map(|v| v.0)
                .collect(),
            DataType::U8 => self.floats::<u8, N>(these, data, 255.0),
            DataType::I8 => self.floats::<i8, N>(these, data, 127.0),
            DataType::U16 => self.floats::<u16, N>(these, data, 65535.0),
            DataType::I16 => self.floats::<i16, N>(these, data, 32767.0),
            DataType::U32 => return Err(self.fault("holds whole numbers of 32 bits")),
        };
        let is_finite = |vector: &[f32; N]| vector.iter().all(|number| number.is_finite());
        if let Some(i) = vectors.iter().position(|vector| !is_finite(vector)) {
            let element = these.map_or(i, |these| these[i] as usize);
            return Err(self.fault(format!("holds {:?} as element {element}", vectors[i])));
        }
        Ok(vectors)
    }

    /// Returns matrices of four columns. Returns an error if they are of another kind or not finite.
    pub(super) fn matrices(&self, data: &mut FileBytes<'_>) -> Result<Vec<[f32; 16]>, Invalid> {
        let is_float = self.accessor.data_type() == DataType::F32;
        if !is_float || self.accessor.dimensions() != Dimensions::Mat4 {
            return Err(self.fault("holds no matrices of 16 floats"));
        }
        data.budget.read(16 * self.count() as u64)?;
        let matrices: Vec<[f32; 16]> = self
            .read::<Vector<f32, 16>>(None, data)
            .map(|m| m.0)
            .collect();
        let is_finite = |matrix: &[f32; 16]| matrix.iter().all(|number| number.is_finite());
        match matrices.iter().position(|matrix| !is_finite(matrix)) {
            Some(i) => Err(self.fault(format!("holds {:?} as element {i}", matrices[i]))),
            None => Ok(matrices),
        }
    }

    /// Returns vectors of integers as floats. For normalized ones, the greatest integer denotes 1
    /// (section 3.11).
    fn floats<C: Item + Copy + Into<f32>, const N: usize>(
        &self,
        these: Option<&[u32]>,
        data: &FileBytes<'_>,
        greatest: f32,
    ) -> Vec<[f32; N]> {
        let is_normalized = self.accessor.normalized();
        let float = |component: C| match is_normalized {
            true => (component.into() / greatest).max(-1.0),
            false => component.into(),
        };
        let vectors = self.read::<Vector<C, N>>(these, data);
        vectors.map(|vector| vector.0.map(float)).collect()
    }

    /// Reads the elements with these ascending indices, or all. Their bytes have been checked.
    fn read<'b, T: Item + 'b>(
        &self,
        these: Option<&'b [u32]>,
        data: &'b FileBytes<'_>,
    ) -> Box<dyn Iterator<Item = T> + 'b> {
        let fetched = |buffer: gltf::Buffer<'_>| data.fetched_buffer(buffer.index());
        let all = match self.count() {
            0 => None,
            _ => Iter::<T>::new(self.accessor.clone(), fetched),
        };
        let zeros = these.map_or(self.count(), <[u32]>::len);
        match (all, these) {
            (None, _) => Box::new((0..zeros).map(|_| T::zero())),
            (Some(all), None) => Box::new(all),
            (Some(mut all), Some(these)) => {
                let mut next = 0;
                Box::new(these.iter().filter_map(move |&i| {
                    let skipped = i - next;
                    next = i + 1;
                    all.nth(skipped as usize)
                }))
            }
        }
    }
}

/// A vector as stored. The crate implements [`Item`] for arrays of 2, 3 and 4, but not for arrays
/// of any length.
#[derive(Clone, Copy)]
struct Vector<C, const N: usize>([C; N]);

impl<C: Item + Copy, const N: usize> Item for Vector<C, N> {
    fn from_slice(bytes: &[u8]) -> Self {
        Self(std::array::from_fn(|i| {
            C::from_slice(&bytes[i * size_of::<C>()..])
        }))
    }

    fn zero() -> Self {
        Self([C::zero(); N])
    }
}

/// Returns an error unless all bytes of an accessor are available.
fn check(accessor: &Accessor<'_>, data: &mut FileBytes<'_>) -> Result<(), Invalid> {
    let (count, size) = (accessor.count(), accessor.size());
    if count > u32::MAX as usize {
        let why = format!("states {count} elements");
        return Err(Invalid::new("its count", why, "split the mesh"));
    }
    if let Some(sparse) = accessor.sparse() {
        check_sparse(&sparse, count, size, data)?;
    }
    if let Some(view) = accessor.view() {
        data.elements(&view, accessor.offset(), size, count)?;
    }
    Ok(())
}

/// Returns an error unless the replacing elements are available and in order.
/// [`document`](super::document) removes empty lists.
fn check_sparse(
    sparse: &Sparse<'_>,
    elements: usize,
    size: usize,
    data: &mut FileBytes<'_>,
) -> Result<(), Invalid> {
    let count = sparse.count();
    if count > elements {
        let why = format!("replaces {count} of {elements} elements");
        return Err(broken_element("sparse", why));
    }
    data.budget.read(count as u64)?;
    let (indices, values) = (sparse.indices(), sparse.values());
    let width = indices.index_type().size();
    let bytes = data
        .elements(&indices.view(), indices.offset(), width, count)
        .map_err(|e| e.within_context("sparse indices"))?;
    let mut least = 0;
    for index in bytes.chunks(indices.view().stride().unwrap_or(width)) {
        let mut word = [0; 4];
        word[..width].copy_from_slice(&index[..width]);
        let index = u32::from_le_bytes(word);
        let why = match index as usize {
            beyond if beyond >= elements => format!("hold {beyond}, of {elements} elements"),
            index if index < least => format!("hold {index} after {}, and must rise", least - 1),
            index => {
                least = index + 1;
                continue;
            }
        };
        return Err(broken_element("sparse indices", why));
    }
    data.elements(&values.view(), values.offset(), size, count)
        .map(drop)
        .map_err(|e| e.within_context("sparse values"))
}
