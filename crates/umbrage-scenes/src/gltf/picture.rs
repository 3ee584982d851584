//! Images: PNG and JPEG, from bytes in the file or next to it.

use super::{
    budget::ReadBudget,
    document::{broken_element, element_name},
    file_bytes::{Fetched, FileBytes},
};
use crate::detail::{Meaning, PICTURE_SIDE, decode_picture, texture_of};
use gltf::{Document, json::image::Image};
use image::{ImageFormat, ImageReader};
use std::{collections::HashMap, io::Cursor, path::Path, rc::Rc};
use umbrage_core::{Invalid, Texture};

/// The images of a file, each read once for each meaning.
#[derive(Debug)]
pub(super) struct Pictures<'a> {
    document: &'a Document,
    known: HashMap<(usize, Meaning), Option<usize>>,
    /// A line for each ignored image.
    pub(super) notices: Vec<String>,
}

impl<'a> Pictures<'a> {
    pub(super) fn new(document: &'a Document) -> Self {
        Self {
            document,
            known: HashMap::new(),
            notices: Vec::new(),
        }
    }

    /// Returns the index of an image among `textures`. `None` if it is missing or of another kind.
    /// Only alpha tests need images for shadows.
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
        let image = &self.document.as_json().images[index];
        let name = element_name("image", index, image.name.as_deref());
        let texture = self
            .read(image, &name, meaning, data)
            .map_err(|e| e.within_context(&name))?;
        if texture.is_none() {
            let notice = format!("{name} is ignored: it is missing, or neither PNG nor JPEG");
            if !self.notices.contains(&notice) {
                self.notices.push(notice);
            }
        }
        let place = texture.map(|texture| {
            textures.push(texture);
            textures.len() - 1
        });
        self.known.insert((index, meaning), place);
        Ok(place)
    }

    fn read(
        &self,
        image: &Image,
        name: &str,
        meaning: Meaning,
        data: &mut FileBytes<'_>,
    ) -> Result<Option<Texture>, Invalid> {
        let own = image
            .buffer_view
            .and_then(|view| self.document.views().nth(view.value()));
        let bytes = match (own, &image.uri) {
            (Some(view), _) => Fetched::Apart(Rc::new(data.view(&view)?.to_vec())),
            (None, Some(uri)) => {
                if !uri.starts_with("data:") && !data.files.has(&data.path(uri)?) {
                    return Ok(None);
                }
                // The document doesn't state its length.
                data.fetch(uri, u64::MAX)?
            }
            (None, None) => {
                let why = "are missing: it has neither a URI nor a buffer view";
                return Err(broken_element("its bytes", why));
            }
        };
        decode(bytes.slice(), image, name, meaning, &mut data.budget)
    }
}

fn decode(
    bytes: &[u8],
    image: &Image,
    name: &str,
    meaning: Meaning,
    budget: &mut ReadBudget,
) -> Result<Option<Texture>, Invalid> {
    let format = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => format,
        _ if is_of_another_kind(image) => return Ok(None),
        _ => {
            return Err(Invalid::new(
                "its bytes",
                "are neither a PNG nor a JPEG image",
                "save it as one of the two",
            ));
        }
    };
    let unreadable = |e| {
        Invalid::new(
            "its bytes",
            format!("can't be decoded: {e}"),
            format!("save it again, at most {PICTURE_SIDE} texels a side"),
        )
    };
    // Read its size from its header.
    let [width, height] = ImageReader::with_format(Cursor::new(bytes), format)
        .into_dimensions()
        .map(|(width, height)| [width, height].map(u64::from))
        .map_err(unreadable)?;
    budget.decode(width * height)?;
    let picture = decode_picture(Cursor::new(bytes), format).map_err(unreadable)?;
    Ok(Some(texture_of(name.to_owned(), &picture, meaning)))
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
