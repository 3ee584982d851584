//! Bytes of the `.glb` file itself, of data URIs, and of other files. They are fetched once each,
//! at their first use.

use super::{
    budget::ReadBudget,
    document::{broken_element, element_name},
};
use crate::{Files, SceneError};
use base64::{Engine as _, engine::general_purpose::STANDARD};
use gltf::{
    Buffer, Document,
    buffer::{Source, View},
};
use percent_encoding::percent_decode_str;
use std::{
    collections::HashMap,
    io::{self, Read as _},
    path::{Path, PathBuf},
    rc::Rc,
};
use umbrage_core::Invalid;

/// The bytes of a document, and its remaining limits.
pub(super) struct FileBytes<'a> {
    pub(super) budget: ReadBudget,
    binary: Option<&'a [u8]>,
    /// The folder that URIs are relative to.
    folder: PathBuf,
    pub(super) files: &'a dyn Files,
    fetched: Vec<Option<Fetched<'a>>>,
    /// Files that several buffers and images may share, and how many bytes of each were requested.
    read: HashMap<PathBuf, (Rc<Vec<u8>>, u64)>,
}

/// Fetched bytes.
#[derive(Clone, Debug)]
pub(super) enum Fetched<'a> {
    InFile(&'a [u8]),
    Apart(Rc<Vec<u8>>),
}

impl Fetched<'_> {
    pub(super) fn slice(&self) -> &[u8] {
        match self {
            Self::InFile(bytes) => bytes,
            Self::Apart(bytes) => bytes,
        }
    }
}

impl<'a> FileBytes<'a> {
    pub(super) fn new(
        document: &Document,
        binary: Option<&'a [u8]>,
        budget: ReadBudget,
        path: &Path,
        files: &'a dyn Files,
    ) -> Self {
        Self {
            budget,
            binary,
            folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
            files,
            fetched: vec![None; document.buffers().len()],
            read: HashMap::new(),
        }
    }

    /// Returns the bytes of a buffer if they have been fetched.
    pub(super) fn fetched_buffer(&self, buffer: usize) -> Option<&[u8]> {
        Some(self.fetched[buffer].as_ref()?.slice())
    }

    /// Returns the bytes of a number of elements of a view, from `start` on.
    pub(super) fn elements(
        &mut self,
        view: &View<'_>,
        start: usize,
        size: usize,
        count: usize,
    ) -> Result<&[u8], Invalid> {
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            let why = format!("is {stride}, less than an element's {size} bytes");
            return Err(broken_element("the stride of its view", why));
        }
        let bytes = self.view(view)?;
        let Some(before_last) = count.checked_sub(1) else {
            return Ok(&[]);
        };
        // 128 bits hold every product of numbers in a file.
        let end = start as u128 + before_last as u128 * stride as u128 + size as u128;
        let there = bytes.len();
        if end <= there as u128 {
            return Ok(&bytes[start..end as usize]);
        }
        let why = format!("has {there} bytes, and element {before_last} would end at byte {end}");
        Err(broken_element(view_name(view), why))
    }

    /// Returns the bytes of a view.
    pub(super) fn view(&mut self, view: &View<'_>) -> Result<&[u8], Invalid> {
        let buffer = view.buffer();
        let buffer_name = element_name("buffer", buffer.index(), buffer.name());
        self.fetch_buffer(&buffer).map_err(|e| {
            e.within_context(&buffer_name)
                .within_context(view_name(view))
        })?;
        let bytes = self.fetched_buffer(buffer.index()).unwrap_or(&[]);
        // A buffer may be longer than it states: chunks of `.glb` files are padded.
        let there = bytes.len().min(buffer.length());
        let end = view.offset().saturating_add(view.length());
        if end > there {
            let why = format!("ends at byte {end} of {buffer_name}, which has {there}");
            return Err(broken_element(view_name(view), why));
        }
        Ok(&bytes[view.offset()..end])
    }

    fn fetch_buffer(&mut self, buffer: &Buffer<'_>) -> Result<(), Invalid> {
        if self.fetched[buffer.index()].is_some() {
            return Ok(());
        }
        let first = (buffer.index() == 0).then_some(self.binary).flatten();
        let bytes = match (buffer.source(), first) {
            (Source::Uri(uri), _) => self.fetch(uri, buffer.length() as u64)?,
            (Source::Bin, Some(binary)) => Fetched::InFile(binary),
            (Source::Bin, None) => {
                let why = "are missing: it has no URI, and is not a chunk of a .glb file";
                return Err(broken_element("its bytes", why));
            }
        };
        let there = bytes.slice().len();
        if there < buffer.length() {
            let why = format!("states {} bytes, and there are {there}", buffer.length());
            return Err(broken_element("its length", why));
        }
        self.fetched[buffer.index()] = Some(bytes);
        Ok(())
    }

    /// Returns the bytes that a URI names or holds. At most `most` bytes of a file are read, so
    /// that a small model can't fill memory with other files.
    pub(super) fn fetch(&mut self, uri: &str, most: u64) -> Result<Fetched<'a>, Invalid> {
        if let Some(data) = uri.strip_prefix("data:") {
            return Ok(Fetched::Apart(Rc::new(decode(data)?)));
        }
        let path = self.path(uri)?;
        let mut counted = 0;
        if let Some((bytes, requested)) = self.read.get(&path) {
            counted = bytes.len();
            if most <= *requested || (counted as u64) < *requested {
                return Ok(Fetched::Apart(bytes.clone()));
            }
        }
        let mut bytes = Vec::new();
        self.files
            .open(&path)
            .and_then(|source| source.take(most).read_to_end(&mut bytes))
            .map_err(|e| missing_file(&path, &e, self.files))?;
        self.budget.add_bytes(bytes.len().saturating_sub(counted));
        let bytes = Rc::new(bytes);
        self.read.insert(path, (bytes.clone(), most));
        Ok(Fetched::Apart(bytes))
    }

    /// Returns the path of the file that a URI names. It may be in any folder, as in other models.
    pub(super) fn path(&self, uri: &str) -> Result<PathBuf, Invalid> {
        // A letter and a colon may be a drive, which is a different one on other machines.
        let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
        if let Some(scheme) = scheme.filter(|scheme| !scheme.contains(['/', '.', '%'])) {
            return Err(Invalid::new(
                "its URI",
                format!("begins with `{scheme}:`"),
                "name a file next to the model by its relative path, or put the bytes into the file",
            ));
        }
        let name = percent_decode_str(uri).decode_utf8_lossy();
        Ok(self.folder.join(name.replace('\\', "/")))
    }
}

fn view_name(view: &View<'_>) -> String {
    element_name("buffer view", view.index(), view.name())
}

/// Returns the error of a file that is missing from `files`.
fn missing_file(path: &Path, error: &io::Error, files: &dyn Files) -> Invalid {
    let what = path.display().to_string();
    match SceneError::unreadable_file(path, error, files) {
        SceneError::Unreadable { why, help, .. } => Invalid::new(what, why, help),
        other => Invalid::new(what, other.to_string(), "check the path"),
    }
}

/// Returns the bytes of a data URI, given its text after `data:` (RFC 2397).
fn decode(data: &str) -> Result<Vec<u8>, Invalid> {
    let (kind, text) = data
        .split_once(',')
        .ok_or_else(|| broken_element("its data URI", "has no comma before the data"))?;
    let text: Vec<u8> = percent_decode_str(text).collect();
    if !kind.ends_with(";base64") {
        return Ok(text);
    }
    STANDARD
        .decode(&text)
        .map_err(|e| broken_element("its data URI", format!("is not base64: {e}")))
}
