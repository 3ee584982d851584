//! Cards as files.

use super::Card;
use crate::LabError;
use std::{fs, path::Path};
use umbrage_core::Invalid;
use umbrage_plan::cost::PriceList;

/// Reads the cards of a folder, `*.json`, by name of their adapters; hardware first.
///
/// # Errors
/// Errors if the folder can't be read or a file is no card.
pub fn read_all(folder: &Path) -> Result<Vec<Card>, LabError> {
    let mut cards = Vec::new();
    let entries = fs::read_dir(folder).map_err(|e| LabError::write(folder, e))?;
    for entry in entries {
        let path = entry.map_err(|e| LabError::write(folder, e))?.path();
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

/// Reads a card.
///
/// # Errors
/// Errors if the file can't be read or is no card.
pub fn read(path: &Path) -> Result<Card, LabError> {
    let text = fs::read_to_string(path).map_err(|e| LabError::write(path, e))?;
    serde_json::from_str(&text).map_err(|e| {
        let why = format!("`{}` cannot be read: {e}", path.display());
        Invalid::new("card", why, "write it again with `cargo xtask card`").into()
    })
}

/// Reads the prices in a card's file: its adapter's, and the built-in ones of the CPU.
///
/// # Errors
/// Errors if the file is no card, or has no prices.
pub fn read_prices(path: &Path) -> Result<PriceList, LabError> {
    let card = read(path)?;
    let Some(wgpu) = card.prices else {
        let why = format!("`{}` has no prices", path.display());
        let help = "measure them with `cargo xtask card`";
        return Err(Invalid::new("card", why, help).into());
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
