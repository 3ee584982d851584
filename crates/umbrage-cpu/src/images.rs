//! Images of a recipe: allocation, clearing and views for kernels.

use crate::cast;
use rayon::prelude::*;
use umbrage_core::{Image, ImageId, ImageView, Recipe};

/// Adapts `images` to a recipe, and reuses those of the right size. Clears the layers that are read
/// before they are written.
pub(crate) fn prepare_images(images: &mut Vec<Image>, recipe: &Recipe) {
    images.truncate(recipe.images.len());
    for (i, desc) in recipe.images.iter().enumerate() {
        let start = desc.format.start();
        match images.get_mut(i) {
            Some(image) if image.desc.floats() == desc.floats() => {
                image.desc = *desc;
                clear_unwritten(image, i, recipe, start);
            }
            Some(image) => *image = Image::filled_with(*desc, start),
            None => images.push(Image::filled_with(*desc, start)),
        }
    }
}

/// Fills the layers of an image that may be read before a stage writes them with `start`.
fn clear_unwritten(image: &mut Image, id: ImageId, recipe: &Recipe, start: f32) {
    for layer in 0..image.desc.layers {
        // The first cast that uses a layer clears it, if it draws there. A filter writes every
        // texel.
        let first_filter = recipe
            .filters
            .iter()
            .find(|f| f.output == id || f.inputs.contains(&id));
        let is_filtered_first = first_filter.is_some_and(|f| f.output == id);
        if cast::clears(recipe, id, layer) || is_filtered_first {
            continue;
        }
        let parts = image.layer_mut(layer).par_chunks_mut(1 << 14);
        parts.for_each(|part| part.fill(start));
    }
}

/// Returns views of the images with these ids, for kernels.
pub(crate) fn views<'a>(images: &'a [Image], ids: &[ImageId]) -> Vec<ImageView<'a>> {
    ids.iter().map(|&i| images[i].view()).collect()
}
