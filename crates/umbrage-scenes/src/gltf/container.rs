//! The parts of a file: JSON alone, or the chunks of a `.glb` file.

use super::broken;
use umbrage_core::Invalid;

/// Length of the header, and of the header of each chunk.
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// A file's parts.
#[derive(Debug)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// The bytes of the first buffer of a `.glb` file.
    pub(super) binary: Option<&'a [u8]>,
}

/// Parts a file by what it holds, whatever it is called.
pub(super) fn split(bytes: &[u8]) -> Result<Container<'_>, Invalid> {
    if bytes.is_empty() {
        return Err(Invalid::new(
            "file",
            "is empty",
            "copy or download it again",
        ));
    }
    if !bytes.starts_with(b"glTF") {
        // Some editors put a mark of byte order in front.
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return Ok(Container { json, binary: None });
    }
    let header = bytes
        .get(..HEADER)
        .ok_or_else(|| cut("the header", HEADER as u64, bytes.len()))?;
    let version = word(&header[4..8]);
    if version != 2 {
        return Err(Invalid::new(
            "header",
            format!("tells version {version} of the format"),
            "export the model as glTF 2.0",
        ));
    }
    let length = word(&header[8..12]);
    if u64::from(length) > bytes.len() as u64 {
        return Err(cut("the header", u64::from(length), bytes.len()));
    }
    // What stands behind the end that the header tells is no part of the model.
    let mut rest = bytes[..length as usize].get(HEADER..).unwrap_or(&[]);
    let json = match next_chunk(&mut rest)? {
        Some(chunk) if chunk.kind == *b"JSON" => chunk.bytes,
        _ => return Err(broken("first chunk", "is not JSON")),
    };
    let mut binary = None;
    // Chunks of other kinds are to be passed over.
    while let Some(chunk) = next_chunk(&mut rest)? {
        if chunk.kind == *b"BIN\0" && binary.is_none() {
            binary = Some(chunk.bytes);
        }
    }
    Ok(Container { json, binary })
}

/// A part of a `.glb` file.
struct Chunk<'a> {
    kind: [u8; 4],
    bytes: &'a [u8],
}

/// Takes the next chunk off; none at the end.
fn next_chunk<'a>(rest: &mut &'a [u8]) -> Result<Option<Chunk<'a>>, Invalid> {
    if rest.is_empty() {
        return Ok(None);
    }
    let header = rest
        .get(..CHUNK_HEADER)
        .ok_or_else(|| cut("the header of a chunk", CHUNK_HEADER as u64, rest.len()))?;
    let length = word(&header[..4]) as usize;
    let kind = [header[4], header[5], header[6], header[7]];
    let after = &rest[CHUNK_HEADER..];
    let bytes = after
        .get(..length)
        .ok_or_else(|| cut("a chunk", length as u64, after.len()))?;
    *rest = &after[length..];
    Ok(Some(Chunk { kind, bytes }))
}

/// The error of a file that ends too early.
fn cut(what: &str, needed: u64, there: usize) -> Invalid {
    Invalid::new(
        "file",
        format!("is cut off: {what} tells {needed} bytes, and there are {there}"),
        "copy or download it again",
    )
}

fn word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}
