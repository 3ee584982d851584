//! Caches of bind groups and their layouts.

use crate::resources::counters::ResourceFactory;
use std::{collections::HashMap, num::NonZeroU64, ops::Range};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, BindingResource, BindingType, Buffer, BufferBinding, BufferBindingType,
    Device, Sampler, SamplerBindingType, ShaderStages, StorageTextureAccess, TextureFormat,
    TextureSampleType, TextureView, TextureViewDimension,
};

/// The kind of one binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Slot {
    Uniform,
    /// A part of a uniform buffer of this size in bytes, whose offset is set at draw time.
    Window(NonZeroU64),
    /// Floats. Depth that is not compared is also bound as unfilterable floats: GL cannot load from
    /// depth textures.
    Floats {
        layered: bool,
    },
    /// Multisampled floats.
    Samples,
    /// Depth for a comparison sampler.
    Depth {
        layered: bool,
    },
    /// Integers: triangle ids, counts.
    Whole {
        layered: bool,
    },
    Table,
    /// A storage buffer that compute shaders write.
    Written,
    /// A texture that compute shaders write.
    Stored {
        format: TextureFormat,
        layered: bool,
    },
    /// A comparison sampler.
    Sampler,
}

impl Slot {
    pub(crate) fn ty(self) -> BindingType {
        let floats = TextureSampleType::Float { filterable: false };
        match self {
            Self::Uniform => buffer_type(BufferBindingType::Uniform, false),
            Self::Window(_) => buffer_type(BufferBindingType::Uniform, true),
            Self::Floats { layered } => texture_type(floats, layered, false),
            Self::Samples => texture_type(floats, false, true),
            Self::Depth { layered } => texture_type(TextureSampleType::Depth, layered, false),
            Self::Whole { layered } => texture_type(TextureSampleType::Uint, layered, false),
            Self::Sampler => BindingType::Sampler(SamplerBindingType::Comparison),
            Self::Table => buffer_type(BufferBindingType::Storage { read_only: true }, false),
            Self::Written => buffer_type(BufferBindingType::Storage { read_only: false }, false),
            Self::Stored { format, layered } => BindingType::StorageTexture {
                access: StorageTextureAccess::WriteOnly,
                format,
                view_dimension: dimension_of(layered),
            },
        }
    }
}

fn buffer_type(ty: BufferBindingType, has_dynamic_offset: bool) -> BindingType {
    BindingType::Buffer {
        ty,
        has_dynamic_offset,
        min_binding_size: None,
    }
}

fn texture_type(sample_type: TextureSampleType, layered: bool, multisampled: bool) -> BindingType {
    BindingType::Texture {
        sample_type,
        view_dimension: dimension_of(layered),
        multisampled,
    }
}

fn dimension_of(layered: bool) -> TextureViewDimension {
    if layered {
        TextureViewDimension::D2Array
    } else {
        TextureViewDimension::D2
    }
}

/// Bind group layouts by their contents, so that equal ones are shared.
#[derive(Debug, Default)]
pub(crate) struct Layouts(HashMap<(ShaderStages, u32, Vec<Slot>), BindGroupLayout>);

impl Layouts {
    pub(crate) fn get(
        &mut self,
        factory: &ResourceFactory<'_>,
        visibility: ShaderStages,
        slots: &[Slot],
    ) -> BindGroupLayout {
        self.get_from(factory, visibility, 0, slots)
    }

    pub(crate) fn get_from(
        &mut self,
        factory: &ResourceFactory<'_>,
        visibility: ShaderStages,
        first: u32,
        slots: &[Slot],
    ) -> BindGroupLayout {
        self.0
            .entry((visibility, first, slots.to_vec()))
            .or_insert_with(|| layout(factory.device, visibility, first, slots))
            .clone()
    }
}

/// Creates a layout with these slots in order, numbered from `first`.
pub(crate) fn layout(
    device: &Device,
    visibility: ShaderStages,
    first: u32,
    slots: &[Slot],
) -> BindGroupLayout {
    let entries: Vec<_> = (first..)
        .zip(slots)
        .map(|(binding, s)| entry(binding, visibility, *s))
        .collect();
    device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some("umbrage"),
        entries: &entries,
    })
}

fn entry(binding: u32, visibility: ShaderStages, slot: Slot) -> BindGroupLayoutEntry {
    BindGroupLayoutEntry {
        binding,
        visibility,
        ty: slot.ty(),
        count: None,
    }
}

/// The resource bound to a slot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Bound {
    Buffer(Buffer),
    /// These bytes of a buffer.
    Part(Buffer, Range<u64>),
    Window(Buffer, NonZeroU64),
    View(TextureView),
    Sampler(Sampler),
}

impl Bound {
    /// Returns a buffer bound to a slot: the whole buffer, or a window.
    pub(crate) fn of_slot(slot: Slot, buffer: Buffer) -> Self {
        match slot {
            Slot::Window(size) => Self::Window(buffer, size),
            _ => Self::Buffer(buffer),
        }
    }

    fn resource(&self) -> BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Part(buffer, bytes) => BindingResource::Buffer(BufferBinding {
                buffer,
                offset: bytes.start,
                size: NonZeroU64::new(bytes.end - bytes.start),
            }),
            Self::Window(buffer, size) => BindingResource::Buffer(BufferBinding {
                buffer,
                offset: 0,
                size: Some(*size),
            }),
            Self::View(view) => BindingResource::TextureView(view),
            Self::Sampler(sampler) => BindingResource::Sampler(sampler),
        }
    }
}

/// A bind group that is recreated only if another resource is bound.
#[derive(Debug, Default)]
pub(crate) struct Binding {
    /// Number of the first binding; the others follow.
    pub(crate) first: u32,
    bound: Vec<Bound>,
    layout: Option<BindGroupLayout>,
    group: Option<BindGroup>,
}

impl Binding {
    pub(crate) fn set(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        label: &str,
        layout: &BindGroupLayout,
        bound: Vec<Bound>,
    ) {
        if self.layout.as_ref() == Some(layout) && self.bound == bound {
            return;
        }
        let entries: Vec<_> = (self.first..)
            .zip(&bound)
            .map(|(binding, b)| BindGroupEntry {
                binding,
                resource: b.resource(),
            })
            .collect();
        let desc = BindGroupDescriptor {
            label: Some(label),
            layout,
            entries: &entries,
        };
        factory.counters.bind_groups += 1;
        self.group = Some(factory.device.create_bind_group(&desc));
        self.layout = Some(layout.clone());
        self.bound = bound;
    }

    /// Binds these resources in order, and returns their layout.
    pub(crate) fn bind(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        layouts: &mut Layouts,
        visibility: ShaderStages,
        label: &str,
        entries: Vec<(Slot, Bound)>,
    ) -> BindGroupLayout {
        let (slots, bound): (Vec<Slot>, Vec<Bound>) = entries.into_iter().unzip();
        let layout = layouts.get_from(factory, visibility, self.first, &slots);
        self.set(factory, label, &layout, bound);
        layout
    }

    /// Returns whether this is the only bound resource.
    pub(crate) fn is_of(&self, only: &Bound) -> bool {
        self.bound == std::slice::from_ref(only)
    }

    pub(crate) fn group(&self) -> Option<&BindGroup> {
        self.group.as_ref()
    }

    pub(crate) fn layout(&self) -> Option<&BindGroupLayout> {
        self.layout.as_ref()
    }
}
