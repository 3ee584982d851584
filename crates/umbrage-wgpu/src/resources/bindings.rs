//! Bind groups and their layouts, each made once.

use crate::resources::counters::ResourceFactory;
use std::{collections::HashMap, num::NonZeroU64};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, BindingResource, BindingType, Buffer, BufferBinding, BufferBindingType,
    Sampler, SamplerBindingType, ShaderStages, TextureSampleType, TextureView,
    TextureViewDimension,
};

/// The kind of one binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Slot {
    Uniform,
    /// A window of this many bytes, moved by an offset at draw time.
    Window(NonZeroU64),
    /// Depth, too, unless it is compared, is bound as unfilterable floats: GL cannot load from depth textures.
    Floats {
        layered: bool,
    },
    /// The same with several samples a texel.
    Samples,
    /// Depth for a comparison sampler.
    Depth {
        layered: bool,
    },
    /// Whole numbers: triangle ids, counts.
    Whole {
        layered: bool,
    },
    Table,
    /// A comparison sampler.
    Sampler,
}

impl Slot {
    fn ty(self) -> BindingType {
        let buffer = |ty, window| BindingType::Buffer {
            ty,
            has_dynamic_offset: window,
            min_binding_size: None,
        };
        let floats = TextureSampleType::Float { filterable: false };
        let texture = |sample_type, layered, multisampled| BindingType::Texture {
            sample_type,
            view_dimension: if layered {
                TextureViewDimension::D2Array
            } else {
                TextureViewDimension::D2
            },
            multisampled,
        };
        match self {
            Self::Uniform => buffer(BufferBindingType::Uniform, false),
            Self::Window(_) => buffer(BufferBindingType::Uniform, true),
            Self::Floats { layered } => texture(floats, layered, false),
            Self::Samples => texture(floats, false, true),
            Self::Depth { layered } => texture(TextureSampleType::Depth, layered, false),
            Self::Whole { layered } => texture(TextureSampleType::Uint, layered, false),
            Self::Sampler => BindingType::Sampler(SamplerBindingType::Comparison),
            Self::Table => buffer(BufferBindingType::Storage { read_only: true }, false),
        }
    }
}

/// Layouts by what they hold, so that equal ones are the same object.
#[derive(Debug, Default)]
pub(crate) struct Layouts(HashMap<(ShaderStages, Vec<Slot>), BindGroupLayout>);

impl Layouts {
    pub(crate) fn get(
        &mut self,
        maker: &ResourceFactory<'_>,
        visibility: ShaderStages,
        slots: &[Slot],
    ) -> BindGroupLayout {
        let make = || {
            let entries: Vec<_> = (0..)
                .zip(slots)
                .map(|(binding, s)| entry(binding, visibility, *s))
                .collect();
            let desc = BindGroupLayoutDescriptor {
                label: Some("umbrage"),
                entries: &entries,
            };
            maker.device.create_bind_group_layout(&desc)
        };
        self.0
            .entry((visibility, slots.to_vec()))
            .or_insert_with(make)
            .clone()
    }
}

fn entry(binding: u32, visibility: ShaderStages, slot: Slot) -> BindGroupLayoutEntry {
    BindGroupLayoutEntry {
        binding,
        visibility,
        ty: slot.ty(),
        count: None,
    }
}

/// Something bound.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Bound {
    Buffer(Buffer),
    Window(Buffer, NonZeroU64),
    View(TextureView),
    Sampler(Sampler),
}

impl Bound {
    fn resource(&self) -> BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
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

/// A bind group that is made anew only when something else is bound.
#[derive(Debug, Default)]
pub(crate) struct Binding {
    bound: Vec<Bound>,
    layout: Option<BindGroupLayout>,
    group: Option<BindGroup>,
}

impl Binding {
    pub(crate) fn set(
        &mut self,
        maker: &mut ResourceFactory<'_>,
        label: &str,
        layout: &BindGroupLayout,
        bound: Vec<Bound>,
    ) {
        if self.layout.as_ref() == Some(layout) && self.bound == bound {
            return;
        }
        let entries: Vec<_> = (0..)
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
        maker.counters.bind_groups += 1;
        self.group = Some(maker.device.create_bind_group(&desc));
        self.layout = Some(layout.clone());
        self.bound = bound;
    }

    pub(crate) fn group(&self) -> Option<&BindGroup> {
        self.group.as_ref()
    }

    pub(crate) fn layout(&self) -> Option<&BindGroupLayout> {
        self.layout.as_ref()
    }
}
