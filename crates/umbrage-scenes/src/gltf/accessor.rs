//! Numbers of accessors, read from bytes that are known to be there.

use super::{
    broken,
    budget::ReadBudget,
    buffers::{Buffers, ViewBytes},
    sparse::Sparse,
    told,
};
use gltf::accessor::{Accessor, DataType, Dimensions};
use umbrage_core::Invalid;

/// An accessor all of whose bytes are there.
#[derive(Debug)]
pub(super) struct AccessorNumbers<'a> {
    /// The bytes from the first element on; none for an accessor of zeros.
    base: Option<ViewBytes<'a>>,
    start: usize,
    stride: usize,
    format: ElementFormat,
    count: usize,
    sparse: Option<Sparse<'a>>,
    /// The accessor in errors.
    pub(super) told: String,
}

/// How an element is stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct ElementFormat {
    data: DataType,
    dimensions: Dimensions,
    is_normalized: bool,
}

impl ElementFormat {
    /// Bytes of an element.
    pub(super) fn size(self) -> usize {
        self.data.size() * self.dimensions.multiplicity()
    }
}

impl<'a> AccessorNumbers<'a> {
    /// Looks an accessor up; nothing is copied yet.
    pub(super) fn open(
        accessor: &Accessor<'_>,
        buffers: &mut Buffers<'a>,
        budget: &mut ReadBudget,
    ) -> Result<Self, Invalid> {
        let name = told("accessor", accessor.index(), accessor.name());
        opened(accessor, name.clone(), buffers, budget).map_err(|e| e.within(name))
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Returns whether all elements are zero for want of bytes.
    pub(super) fn is_without_bytes(&self) -> bool {
        self.base.is_none() && self.sparse.is_none()
    }

    /// Returns the error of an accessor that can't be what it is used for.
    pub(super) fn fault(&self, why: impl Into<String>) -> Invalid {
        broken(self.told.as_str(), why)
    }

    /// Returns indices of vertices.
    pub(super) fn indices(&self, budget: &mut ReadBudget) -> Result<Vec<u32>, Invalid> {
        let is_index = self.format.dimensions == Dimensions::Scalar
            && matches!(
                self.format.data,
                DataType::U8 | DataType::U16 | DataType::U32
            );
        if !is_index {
            return Err(self.fault("holds no indices: these are scalars without a sign"));
        }
        budget.read(self.count as u64)?;
        let indices = match self.format.data {
            DataType::U8 => self.elements(None, |bytes| u32::from(bytes[0])),
            DataType::U16 => self.elements(None, |bytes| u32::from(u16_of(bytes))),
            _ => self.elements(None, u32_of),
        };
        Ok(indices)
    }

    /// Returns vectors as 32-bit floats: of these elements, or of all. Errors if they have another length or are not finite.
    pub(super) fn vectors<const N: usize>(
        &self,
        these: Option<&[u32]>,
        budget: &mut ReadBudget,
    ) -> Result<Vec<[f32; N]>, Invalid> {
        let is_vector = matches!(
            self.format.dimensions,
            Dimensions::Vec2 | Dimensions::Vec3 | Dimensions::Vec4
        );
        if !is_vector || self.format.dimensions.multiplicity() != N {
            return Err(self.fault(format!("holds no vectors of {N} numbers")));
        }
        budget.read(these.map_or(self.count, <[u32]>::len) as u64)?;
        // The greatest number of each kind stands for 1, the rest by the specification's table (section 3.11).
        let is_normalized = self.format.is_normalized;
        let unsigned = |value: u32, greatest: f32| match is_normalized {
            true => value as f32 / greatest,
            false => value as f32,
        };
        let signed = |value: i32, greatest: f32| match is_normalized {
            true => (value as f32 / greatest).max(-1.0),
            false => value as f32,
        };
        let vectors = match self.format.data {
            DataType::F32 => self.vectors_by(these, |bytes| f32::from_bits(u32_of(bytes))),
            DataType::U8 => self.vectors_by(these, |bytes| unsigned(u32::from(bytes[0]), 255.0)),
            DataType::I8 => {
                self.vectors_by(these, |bytes| signed(i32::from(bytes[0] as i8), 127.0))
            }
            DataType::U16 => {
                self.vectors_by(these, |bytes| unsigned(u32::from(u16_of(bytes)), 65535.0))
            }
            DataType::I16 => self.vectors_by(these, |bytes| {
                signed(i32::from(u16_of(bytes) as i16), 32767.0)
            }),
            DataType::U32 => return Err(self.fault("holds whole numbers of 32 bits")),
        };
        let is_finite = |vector: &[f32; N]| vector.iter().all(|number| number.is_finite());
        if let Some(i) = vectors.iter().position(|vector| !is_finite(vector)) {
            let element = these.map_or(i, |these| these[i] as usize);
            return Err(self.fault(format!("holds {:?} as element {element}", vectors[i])));
        }
        Ok(vectors)
    }

    /// Returns vectors, given what a number's bytes stand for.
    fn vectors_by<const N: usize>(
        &self,
        these: Option<&[u32]>,
        number: impl Fn(&[u8]) -> f32,
    ) -> Vec<[f32; N]> {
        let size = self.format.data.size();
        self.elements(these, |bytes| {
            std::array::from_fn(|i| number(&bytes[i * size..]))
        })
    }

    /// Returns what elements' bytes stand for: of these elements, in rising order, or of all.
    fn elements<T: Clone>(&self, these: Option<&[u32]>, element: impl Fn(&[u8]) -> T) -> Vec<T> {
        let size = self.format.size();
        let zeros = [0; 16];
        let of_base = |i: usize| match &self.base {
            Some(base) => element(&base.slice()[self.start + i * self.stride..][..size]),
            None => element(&zeros[..size]),
        };
        let mut out: Vec<T> = match these {
            Some(these) => these.iter().map(|&i| of_base(i as usize)).collect(),
            None => (0..self.count).map(of_base).collect(),
        };
        for (at, bytes) in self.sparse.iter().flat_map(Sparse::elements) {
            let place = match these {
                Some(these) => these.binary_search(&at).ok(),
                None => Some(at as usize),
            };
            if let Some(place) = place {
                out[place] = element(bytes);
            }
        }
        out
    }
}

fn opened<'a>(
    accessor: &Accessor<'_>,
    told: String,
    buffers: &mut Buffers<'a>,
    budget: &mut ReadBudget,
) -> Result<AccessorNumbers<'a>, Invalid> {
    let format = ElementFormat {
        data: accessor.data_type(),
        dimensions: accessor.dimensions(),
        is_normalized: accessor.normalized(),
    };
    if accessor.count() > u32::MAX as usize {
        let why = format!("tells {} elements", accessor.count());
        return Err(Invalid::new("its count", why, "split the mesh"));
    }
    let sparse = match accessor.sparse() {
        Some(sparse) => Some(Sparse::open(
            &sparse,
            format,
            accessor.count(),
            buffers,
            budget,
        )?),
        None => None,
    };
    let mut out = AccessorNumbers {
        base: None,
        start: accessor.offset(),
        stride: format.size(),
        format,
        count: accessor.count(),
        sparse,
        told,
    };
    if let Some(view) = accessor.view() {
        out.stride = view.stride().unwrap_or(format.size());
        if out.stride < format.size() {
            let why = format!(
                "is {}, less than an element's {} bytes",
                out.stride,
                format.size()
            );
            return Err(broken("the stride of its view", why));
        }
        let bytes = buffers.view(&view, budget)?;
        check_end(&bytes, out.start, out.stride, format.size(), out.count)?;
        out.base = Some(bytes);
    }
    Ok(out)
}

/// Errors if the last of so many elements ends beyond a view.
pub(super) fn check_end(
    view: &ViewBytes<'_>,
    start: usize,
    stride: usize,
    size: usize,
    count: usize,
) -> Result<(), Invalid> {
    let Some(before_last) = count.checked_sub(1) else {
        return Ok(());
    };
    // Wide enough for whatever numbers a file tells.
    let end = start as u128 + before_last as u128 * stride as u128 + size as u128;
    let there = view.slice().len();
    if end <= there as u128 {
        return Ok(());
    }
    let why = format!("has {there} bytes, and element {before_last} would end at byte {end}");
    Err(broken(view.told.as_str(), why))
}

pub(super) fn u16_of(bytes: &[u8]) -> u16 {
    u16::from_le_bytes([bytes[0], bytes[1]])
}

pub(super) fn u32_of(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}
