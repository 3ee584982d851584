//! Files of cards.

use super::data::{Card, SCHEMA};
use crate::error::LabError;
use serde::Deserialize;
use std::{fs, io, path::Path};
use umbrage_core::Invalid;
use umbrage_plan::cost::PriceList;

/// Reads the cards of a folder, `*.json`, sorted by adapter name, hardware first.
///
/// # Errors
/// Errors if the folder can't be read or a file is not a card.
pub fn read_all(folder: &Path) -> Result<Vec<Card>, Invalid> {
    let unreadable = |e: io::Error| {
        let what = format!("folder of cards `{}`", folder.display());
        let help = "name a folder of files that `cargo xtask card` wrote";
        Invalid::new(what, format!("cannot be read: {e}"), help)
    };
    let mut cards = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path
            .extension()
            .is_some_and(|extension| extension == "json")
        {
            cards.push(read(&path)?);
        }
    }
    cards.sort_by(|a, b| {
        let key = |card: &Card| (card.is_software, card.adapter.clone(), card.date.clone());
        key(a).cmp(&key(b))
    });
    Ok(cards)
}

/// The schema only: cards of other versions have other fields.
#[derive(Deserialize)]
struct CardVersion {
    schema: u32,
}

/// Reads a card.
///
/// # Errors
/// Errors if the file can't be read, is not a card, or has an unsupported schema.
pub fn read(path: &Path) -> Result<Card, Invalid> {
    let again = "write it again with `cargo xtask card`";
    let refuse =
        |why: String, help: &str| Invalid::new(format!("card `{}`", path.display()), why, help);
    let text = fs::read_to_string(path).map_err(|e| {
        let help = "use a file that `cargo xtask card` wrote";
        refuse(format!("cannot be read: {e}"), help)
    })?;
    let CardVersion { schema } =
        serde_json::from_str(&text).map_err(|e| refuse(format!("is not a card: {e}"), again))?;
    if schema != SCHEMA {
        let why = format!("has schema {schema}, this program's is {SCHEMA}");
        return Err(refuse(why, "write it again with this version"));
    }
    serde_json::from_str(&text).map_err(|e| refuse(format!("is damaged: {e}"), again))
}

/// Reads the adapter's prices from a card's file, with the built-in ones of the CPU.
///
/// # Errors
/// Errors if the file is not a card, or has no prices.
pub fn read_prices(path: &Path) -> Result<PriceList, Invalid> {
    let card = read(path)?;
    let Some(wgpu) = card.prices else {
        let what = format!("card `{}`", path.display());
        let help = "measure them with `cargo xtask card`";
        return Err(Invalid::new(what, "has no prices", help));
    };
    Ok(PriceList {
        measured_on: card.adapter,
        wgpu,
        ..PriceList::default()
    })
}

/// Writes a card as JSON.
///
/// # Errors
/// Errors if the file can't be written.
pub fn write(path: &Path, card: &Card) -> Result<(), LabError> {
    let text = serde_json::to_string_pretty(card).map_err(|e| LabError::write(path, e))?;
    fs::write(path, text + "\n").map_err(|e| LabError::write(path, e))
}
