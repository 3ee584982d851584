//! Images: PNG and JPEG, from bytes in the file or next to it.

use super::{
    document::{broken_element, element_name},
    file_bytes::FileBytes,
};
use crate::detail::{EncodedImage, Meaning, PICTURE_SIDE, PendingImages};
use gltf::{Document, json::image::Image};
use image::{ImageError, ImageFormat};
use std::{
    collections::{HashMap, HashSet},
    path::Path,
};
use umbrage_core::{Invalid, Texture};

/// The images of a file, each read once for each meaning.
#[derive(Debug)]
pub(super) struct Pictures<'a> {
    document: &'a Document,
    known: HashMap<(usize, Meaning), Option<usize>>,
    pending: PendingImages,
    /// Images whose texels the limits of the file already count.
    counted: HashSet<usize>,
    /// A line for each ignored image.
    pub(super) notices: Vec<String>,
}

impl<'a> Pictures<'a> {
    pub(super) fn new(document: &'a Document) -> Self {
        Self {
            document,
            known: HashMap::new(),
            pending: PendingImages::default(),
            counted: HashSet::new(),
            notices: Vec::new(),
        }
    }

    /// Returns the index of an image among `textures`. `None` if it is missing or of another kind.
    /// Images without effect on shadows have no texels before [`decode`](Self::decode).
    pub(super) fn texture(
        &mut self,
        index: usize,
        meaning: Meaning,
        data: &mut FileBytes<'_>,
        textures: &mut Vec<Texture>,
    ) -> Result<Option<usize>, Invalid> {
        if let Some(known) = self.known.get(&(index, meaning)) {
            return Ok(*known);
        }
        // Colours of an alpha-tested image that was not too large are those of the whole image.
        if meaning == Meaning::Color
            && let Some(Some(known)) = self.known.get(&(index, Meaning::CutOut))
            && textures[*known].size.max_element() <= data.files.color_side()
        {
            return Ok(Some(*known));
        }
        let image = &self.document.as_json().images[index];
        let name = element_name("image", index, image.name.as_deref());
        let encoded = self
            .read(image, &name, meaning, data)
            .and_then(|encoded| {
                // Count each image once, whatever its number of uses.
                if let Some((_, texels)) = &encoded
                    && self.counted.insert(index)
                {
                    data.budget.decode(*texels)?;
                }
                Ok(encoded.map(|(image, _)| image))
            })
            .map_err(|e| e.within_context(&name))?;
        if encoded.is_none() {
            let notice = format!("{name} is ignored: it is missing, or neither PNG nor JPEG");
            if !self.notices.contains(&notice) {
                self.notices.push(notice);
            }
        }
        let place = match encoded {
            None => None,
            Some(image) if meaning.is_only_shown() => Some(self.pending.add(image, textures)),
            // The check of wrapping reads the texels of alpha tests while meshes are read. Decode
            // only this image, so that errors of others don't name its material.
            Some(image) => {
                let decoded = image.texture();
                textures.push(decoded.map_err(|why| unreadable(&why).within_context(&name))?);
                Some(textures.len() - 1)
            }
        };
        self.known.insert((index, meaning), place);
        Ok(place)
    }

    /// Decodes the images of all textures so far.
    pub(super) fn decode(&mut self, textures: &mut [Texture]) -> Result<(), Invalid> {
        let decoded = self.pending.decode(textures);
        decoded.map_err(|(index, why)| unreadable(&why).within_context(&textures[index].name))
    }

    /// Returns an image and its number of texels.
    fn read(
        &self,
        image: &Image,
        name: &str,
        meaning: Meaning,
        data: &mut FileBytes<'_>,
    ) -> Result<Option<(EncodedImage, u64)>, Invalid> {
        let own = image
            .buffer_view
            .and_then(|view| self.document.views().nth(view.value()));
        let bytes = match (own, &image.uri) {
            (Some(view), _) => data.view(&view)?.to_vec(),
            (None, Some(uri)) => {
                if !uri.starts_with("data:") && !data.files.has(&data.path(uri)?) {
                    return Ok(None);
                }
                // The document doesn't state its length.
                data.fetch(uri, u64::MAX)?.slice().to_vec()
            }
            (None, None) => {
                let why = "are missing: it has neither a URI nor a buffer view";
                return Err(broken_element("its bytes", why));
            }
        };
        let Some(format) = format_of(&bytes, image)? else {
            return Ok(None);
        };
        let encoded = EncodedImage {
            name: name.to_owned(),
            bytes,
            format,
            meaning,
            color_side: data.files.color_side(),
        };
        let (size, _) = encoded.header().map_err(|e| unreadable(&e))?;
        let texels = u64::from(size.x) * u64::from(size.y);
        Ok(Some((encoded, texels)))
    }
}

/// Returns the format of an image. `None` if it declares another one.
fn format_of(bytes: &[u8], image: &Image) -> Result<Option<ImageFormat>, Invalid> {
    match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => Ok(Some(format)),
        _ if is_of_another_kind(image) => Ok(None),
        _ => Err(Invalid::new(
            "its bytes",
            "are neither a PNG nor a JPEG image",
            "save it as one of the two",
        )),
    }
}

fn unreadable(why: &ImageError) -> Invalid {
    Invalid::new(
        "its bytes",
        format!("can't be decoded: {why}"),
        format!("save it again, at most {PICTURE_SIDE} texels a side"),
    )
}

/// Reports whether an image declares itself to be neither PNG nor JPEG.
fn is_of_another_kind(image: &Image) -> bool {
    let ending = |uri: &str| {
        let ending = Path::new(uri).extension()?;
        Some(format!("image/{}", ending.to_str()?.to_ascii_lowercase()))
    };
    let of_uri = || match image.uri.as_deref()? {
        uri if uri.starts_with("data:") => {
            let kind = uri["data:".len()..].split([';', ',']).next()?;
            Some(kind.to_owned())
        }
        uri => ending(uri),
    };
    let mime = image.mime_type.as_ref().map(|kind| kind.0.clone());
    match mime.or_else(of_uri).as_deref() {
        None | Some("" | "image/png" | "image/jpeg" | "image/jpg") => false,
        Some(_) => true,
    }
}
