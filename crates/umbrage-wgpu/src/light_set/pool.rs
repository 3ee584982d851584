//! Storage of the lights' maps: textures with many layers, one for each size and format. Each light
//! has some consecutive layers.

use crate::resources::{
    counters::ResourceFactory,
    images::{GpuImage, layered_texture, layers_view},
};
use glam::UVec2;
use std::ops::Range;
use umbrage_core::{Format, ImageDesc};
use wgpu::{Texture, TextureAspect, TextureView, TextureViewDimension};

/// Size and format of the layers of one texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LayerClass {
    pub(crate) size: UVec2,
    pub(crate) format: Format,
}

/// Consecutive layers of one class that belong together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LayerRange {
    /// Index of the class in the pool.
    pub(crate) class: usize,
    pub(crate) layers: Range<u32>,
}

#[derive(Debug)]
struct ClassTexture {
    class: LayerClass,
    /// Ranges in use, rising.
    used: Vec<Range<u32>>,
    /// Required number of layers.
    wanted: u32,
    texture: Option<Texture>,
    /// The texture with all layers, for kernels.
    whole: Option<TextureView>,
}

/// All classes. Classes are never removed, so that shaders that refer to them stay the same.
#[derive(Debug, Default)]
pub(crate) struct LayerPool {
    classes: Vec<ClassTexture>,
}

impl LayerClass {
    pub(crate) fn of_image(image: &ImageDesc) -> Self {
        Self {
            size: image.size,
            format: image.format,
        }
    }
}

impl LayerPool {
    /// Allocates as many consecutive layers as an image has; `None` if a texture of this class
    /// would need more than `most`.
    pub(crate) fn take(&mut self, image: &ImageDesc, most: u32) -> Option<LayerRange> {
        let class = LayerClass::of_image(image);
        let known = self.classes.iter().position(|c| c.class == class);
        let index = known.unwrap_or_else(|| {
            self.classes.push(ClassTexture {
                class,
                used: Vec::new(),
                wanted: 0,
                texture: None,
                whole: None,
            });
            self.classes.len() - 1
        });
        let held = &mut self.classes[index];
        let (place, start) = held.first_gap(image.layers);
        let layers = start..start + image.layers;
        if layers.end > most {
            return None;
        }
        held.wanted = held.wanted.max(layers.end);
        held.used.insert(place, layers.clone());
        Some(LayerRange {
            class: index,
            layers,
        })
    }

    pub(crate) fn give_back(&mut self, range: &LayerRange) {
        self.classes[range.class]
            .used
            .retain(|used| *used != range.layers);
    }

    /// Replaces the textures that are too small. Returns the classes whose layers are lost.
    pub(crate) fn make_textures(&mut self, factory: &mut ResourceFactory<'_>) -> Vec<usize> {
        let mut lost = Vec::new();
        for (index, held) in self.classes.iter_mut().enumerate() {
            let has = held
                .texture
                .as_ref()
                .map_or(0, Texture::depth_or_array_layers);
            if held.wanted <= has {
                continue;
            }
            let desc = ImageDesc {
                label: "umbrage maps",
                size: held.class.size,
                layers: held.wanted,
                format: held.class.format,
            };
            let texture = layered_texture(factory, &desc);
            let dimension = TextureViewDimension::D2Array;
            let all = TextureAspect::All;
            held.whole = Some(layers_view(
                &texture,
                desc.label,
                dimension,
                all,
                0..held.wanted,
            ));
            held.texture = Some(texture);
            lost.push(index);
        }
        lost
    }

    /// Returns an image in these layers; `None` before their texture is created.
    pub(crate) fn image(&self, desc: ImageDesc, range: &LayerRange) -> Option<GpuImage> {
        let texture = self.classes[range.class].texture.clone()?;
        Some(GpuImage::window(texture, desc, range.layers.start))
    }

    /// Returns the view of all layers of a class.
    pub(crate) fn whole(&self, class: usize) -> Option<&TextureView> {
        self.classes[class].whole.as_ref()
    }

    /// Returns all classes, by index.
    pub(crate) fn classes(&self) -> Vec<LayerClass> {
        self.classes.iter().map(|held| held.class).collect()
    }

    pub(crate) fn class(&self, index: usize) -> LayerClass {
        self.classes[index].class
    }

    /// Returns the bytes of all textures.
    pub(crate) fn bytes(&self) -> u64 {
        self.classes
            .iter()
            .map(|held| {
                let layers = held
                    .texture
                    .as_ref()
                    .map_or(0, Texture::depth_or_array_layers);
                bytes_of(held.class, layers)
            })
            .sum()
    }
}

impl ClassTexture {
    /// Returns the first gap of `count` layers: the index of its range among those in use, and its
    /// first layer.
    fn first_gap(&self, count: u32) -> (usize, u32) {
        let mut start = 0;
        for (place, used) in self.used.iter().enumerate() {
            if used.start - start >= count {
                return (place, start);
            }
            start = used.end;
        }
        (self.used.len(), start)
    }
}

fn bytes_of(class: LayerClass, layers: u32) -> u64 {
    let desc = ImageDesc {
        label: "",
        size: class.size,
        layers,
        format: class.format,
    };
    desc.bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(side: u32, layers: u32) -> ImageDesc {
        ImageDesc {
            label: "map",
            size: UVec2::splat(side),
            layers,
            format: Format::Depth32,
        }
    }

    #[test]
    fn gaps_are_used_again_and_classes_stay_apart() {
        let mut pool = LayerPool::default();
        let mut take = |side, layers| pool.take(&image(side, layers), 8);
        let first = take(64, 2).expect("fits");
        let second = take(64, 3).expect("fits");
        let other = take(32, 1).expect("fits");
        assert_eq!((first.class, second.class, other.class), (0, 0, 1));
        assert_eq!((first.layers.clone(), second.layers), (0..2, 2..5));
        assert_eq!(other.layers, 0..1);
        assert_eq!(take(64, 4), None, "eight layers are the limit");
        pool.give_back(&first);
        let mut take = |side, layers| pool.take(&image(side, layers), 8);
        assert_eq!(take(64, 1).expect("fits").layers, 0..1);
        assert_eq!(take(64, 2).expect("fits").layers, 5..7);
        assert_eq!(take(64, 1).expect("fits").layers, 1..2);
    }
}
