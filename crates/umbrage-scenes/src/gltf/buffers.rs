//! Bytes: of the `.glb` file itself, of data URIs, of files beside it. They are fetched when something is read from them, once each.

use super::{broken, budget::ReadBudget, told};
use crate::{Files, SceneError};
use base64::{Engine as _, engine::general_purpose::STANDARD};
use gltf::{
    Document,
    buffer::{Source, View},
};
use std::{
    borrow::Cow,
    collections::HashMap,
    io::{self, Read as _},
    path::{Path, PathBuf},
    rc::Rc,
};
use umbrage_core::Invalid;

/// The buffers of a document.
pub(super) struct Buffers<'a> {
    binary: Option<&'a [u8]>,
    /// The folder that files are named from.
    folder: PathBuf,
    pub(super) files: &'a dyn Files,
    fetched: Vec<Option<Bytes<'a>>>,
    /// Files that several buffers may share.
    read: HashMap<PathBuf, ReadFile>,
}

/// What was read of a file.
#[derive(Clone, Debug)]
struct ReadFile {
    bytes: Rc<Vec<u8>>,
    /// How much was asked for.
    most: u64,
}

impl ReadFile {
    /// Returns whether reading up to so many bytes would give no more.
    fn has(&self, most: u64) -> bool {
        most <= self.most || (self.bytes.len() as u64) < self.most
    }
}

/// Bytes that were fetched.
#[derive(Clone, Debug)]
pub(super) enum Bytes<'a> {
    InFile(&'a [u8]),
    Apart(Rc<Vec<u8>>),
}

impl Bytes<'_> {
    pub(super) fn slice(&self) -> &[u8] {
        match self {
            Self::InFile(bytes) => bytes,
            Self::Apart(bytes) => bytes,
        }
    }
}

/// A part of a buffer, with what it takes to tell it in errors.
#[derive(Clone, Debug)]
pub(super) struct ViewBytes<'a> {
    bytes: Bytes<'a>,
    start: usize,
    length: usize,
    pub(super) told: String,
}

impl ViewBytes<'_> {
    pub(super) fn slice(&self) -> &[u8] {
        &self.bytes.slice()[self.start..][..self.length]
    }
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        document: &Document,
        binary: Option<&'a [u8]>,
        path: &Path,
        files: &'a dyn Files,
    ) -> Self {
        Self {
            binary,
            folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
            files,
            fetched: vec![None; document.buffers().len()],
            read: HashMap::new(),
        }
    }

    /// Returns the bytes of a view, all of which are there.
    pub(super) fn view(
        &mut self,
        view: &View<'_>,
        budget: &mut ReadBudget,
    ) -> Result<ViewBytes<'a>, Invalid> {
        let name = told("buffer view", view.index(), view.name());
        let buffer = view.buffer();
        let bytes = self
            .buffer(&buffer, budget)
            .map_err(|e| e.within(told("buffer", buffer.index(), buffer.name())))
            .map_err(|e| e.within(&name))?;
        // A buffer may be longer than it tells: chunks of `.glb` files are padded.
        let there = bytes.slice().len().min(buffer.length()) as u64;
        let end = (view.offset() as u64).saturating_add(view.length() as u64);
        if end > there {
            let buffer = told("buffer", buffer.index(), buffer.name());
            let why = format!("ends at byte {end} of {buffer}, which has {there}");
            return Err(broken(name, why));
        }
        Ok(ViewBytes {
            bytes,
            start: view.offset(),
            length: view.length(),
            told: name,
        })
    }

    fn buffer(
        &mut self,
        buffer: &gltf::Buffer<'_>,
        budget: &mut ReadBudget,
    ) -> Result<Bytes<'a>, Invalid> {
        if let Some(bytes) = &self.fetched[buffer.index()] {
            return Ok(bytes.clone());
        }
        let bytes = match buffer.source() {
            Source::Bin => self.binary(buffer)?,
            Source::Uri(uri) => self.fetch(uri, buffer.length() as u64, budget)?,
        };
        let there = bytes.slice().len();
        if there < buffer.length() {
            let why = format!("tells {} bytes, and there are {there}", buffer.length());
            return Err(broken("its length", why));
        }
        self.fetched[buffer.index()] = Some(bytes.clone());
        Ok(bytes)
    }

    fn binary(&self, buffer: &gltf::Buffer<'_>) -> Result<Bytes<'a>, Invalid> {
        let first = (buffer.index() == 0).then_some(self.binary).flatten();
        first.map(Bytes::InFile).ok_or_else(|| {
            broken(
                "its bytes",
                "are nowhere: it has no URI, and is no chunk of a .glb file",
            )
        })
    }

    /// Returns the bytes that a URI names, or holds. Of a file `most` bytes are read, however long it is, so that a small model can't have
    /// memory filled with what lies beside it.
    pub(super) fn fetch(
        &mut self,
        uri: &str,
        most: u64,
        budget: &mut ReadBudget,
    ) -> Result<Bytes<'a>, Invalid> {
        if let Some(data) = uri.strip_prefix("data:") {
            return decode(data).map(|bytes| Bytes::Apart(Rc::new(bytes)));
        }
        let path = self.path(uri)?;
        let known = self.read.get(&path);
        if let Some(known) = known.filter(|known| known.has(most)) {
            return Ok(Bytes::Apart(known.bytes.clone()));
        }
        let counted = known.map_or(0, |known| known.bytes.len());
        let mut bytes = Vec::new();
        let files = self.files;
        files
            .open(&path)
            .and_then(|source| source.take(most).read_to_end(&mut bytes))
            .map_err(|e| missing(&path, &e, files))?;
        budget.add_bytes(bytes.len().saturating_sub(counted));
        let bytes = Rc::new(bytes);
        let read = ReadFile {
            bytes: bytes.clone(),
            most,
        };
        self.read.insert(path, read);
        Ok(Bytes::Apart(bytes))
    }

    /// Returns the path of a file that a URI names. As in other models, it may lie in any folder.
    pub(super) fn path(&self, uri: &str) -> Result<PathBuf, Invalid> {
        // A letter and a colon may be a drive: that is refused, too, since it is another one elsewhere.
        let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
        if let Some(scheme) = scheme.filter(|scheme| !scheme.contains(['/', '.', '%'])) {
            return Err(Invalid::new(
                "its URI",
                format!("begins with `{scheme}:`"),
                "name a file beside the model by its relative path, or put the bytes into the file",
            ));
        }
        let name = percent_decoded(uri);
        let name = String::from_utf8_lossy(&name).replace('\\', "/");
        Ok(self.folder.join(name))
    }
}

/// The error of a file that was looked for among `files`.
fn missing(path: &Path, error: &io::Error, files: &dyn Files) -> Invalid {
    let what = path.display().to_string();
    match SceneError::unreadable(path, error, files) {
        SceneError::Unreadable { why, help, .. } => Invalid::new(what, why, help),
        other => Invalid::new(what, other.to_string(), "check the path"),
    }
}

/// Returns the bytes of a data URI, from behind `data:`: RFC 2397.
fn decode(data: &str) -> Result<Vec<u8>, Invalid> {
    let (kind, text) = data
        .split_once(',')
        .ok_or_else(|| broken("its data URI", "has no comma before the data"))?;
    let text = percent_decoded(text);
    if !kind.ends_with(";base64") {
        return Ok(text.into_owned());
    }
    STANDARD
        .decode(&text)
        .map_err(|e| broken("its data URI", format!("is not base64: {e}")))
}

/// Returns the bytes that a URI's text stands for: `%20` is a blank. What is no such code stays as it is.
fn percent_decoded(text: &str) -> Cow<'_, [u8]> {
    if !text.contains('%') {
        return Cow::Borrowed(text.as_bytes());
    }
    let mut rest = text.as_bytes();
    let mut out = Vec::with_capacity(rest.len());
    while let Some((&first, behind)) = rest.split_first() {
        let digits = behind.get(..2).filter(|_| first == b'%');
        let code = digits
            .and_then(|digits| std::str::from_utf8(digits).ok())
            .filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()))
            .and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match code {
            Some(code) => {
                out.push(code);
                rest = &behind[2..];
            }
            None => {
                out.push(first);
                rest = behind;
            }
        }
    }
    Cow::Owned(out)
}
