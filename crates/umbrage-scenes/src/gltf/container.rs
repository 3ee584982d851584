//! The parts of a file: JSON alone, or the chunks of a `.glb` file.

use super::document::broken_element;
use umbrage_core::Invalid;

/// The parts of a file.
#[derive(Debug)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// The bytes of the first buffer of a `.glb` file.
    pub(super) binary: Option<&'a [u8]>,
}

/// Splits a file by content, ignoring its extension.
///
/// [`gltf::Glb`] refuses chunks of unknown types, which readers must skip, and panics if the
/// header's length is too small.
pub(super) fn split(bytes: &[u8]) -> Result<Container<'_>, Invalid> {
    if bytes.is_empty() {
        return Err(damaged_container("is empty".to_owned()));
    }
    if !bytes.starts_with(b"glTF") {
        // Some editors write a byte order mark.
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return Ok(Container { json, binary: None });
    }
    let [_, version, length] = take_words("the header", &mut &*bytes)?;
    if version != 2 {
        return Err(Invalid::new(
            "header",
            format!("states version {version} of the format"),
            "export the model as glTF 2.0",
        ));
    }
    // Bytes after the end that the header states are not part of the model.
    let mut rest = bytes
        .get(..length as usize)
        .ok_or_else(|| cut_off("the header", length as usize, bytes.len()))?
        .get(12..)
        .unwrap_or(&[]);
    let mut json = None;
    let mut binary = None;
    while !rest.is_empty() {
        let [length, kind] = take_words("the header of a chunk", &mut rest)?;
        let (chunk, after) = rest
            .split_at_checked(length as usize)
            .ok_or_else(|| cut_off("a chunk", length as usize, rest.len()))?;
        rest = after;
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(chunk),
            _ if json.is_none() => break,
            b"BIN\0" => binary = binary.or(Some(chunk)),
            _ => {}
        }
    }
    let json = json.ok_or_else(|| broken_element("first chunk", "is not JSON"))?;
    Ok(Container { json, binary })
}

/// Removes little-endian words from the front.
fn take_words<const N: usize>(what: &str, bytes: &mut &[u8]) -> Result<[u32; N], Invalid> {
    let words = bytes.as_chunks::<4>().0.first_chunk::<N>();
    let words = words.ok_or_else(|| cut_off(what, 4 * N, bytes.len()))?;
    *bytes = &bytes[4 * N..];
    Ok(words.map(u32::from_le_bytes))
}

fn cut_off(what: &str, needed: usize, there: usize) -> Invalid {
    damaged_container(format!(
        "is cut off: {what} states {needed} bytes, and there are {there}"
    ))
}

fn damaged_container(why: String) -> Invalid {
    Invalid::new("file", why, "copy or download it again")
}
