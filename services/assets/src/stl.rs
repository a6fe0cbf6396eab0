//! STL, text and binary.
//!
//! A file is binary if its length is that which its count of triangles asks for, whatever its first
//! word is: many programs begin the header with `solid`.

use super::raw::{Extra, Raw, triangles_of};
use super::text::{decode, lines, number};
use super::{MAX_TRIANGLES, MeshFileError};
use cullet_geometry::Vec3;

/// Bytes before the triangles of a binary file: a header, and their count.
const HEADER: usize = 84;

/// Bytes of a triangle of a binary file: a normal, three corners, and two more.
const RECORD: usize = 50;

/// Where the corners of a record begin.
const CORNERS: usize = 12;

/// How far into a file its first facet is looked for, to tell text from binary \[bytes\].
const BEGINNING: usize = 4096;

pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshFileError> {
    let count = bytes.get(HEADER - 4..HEADER).and_then(|count| count.try_into().ok());
    let count = count.map_or(0, u32::from_le_bytes) as usize;
    let need = HEADER + count * RECORD;
    if bytes.len() != need && is_text(bytes) {
        return read_text(&decode(bytes));
    }
    if bytes.len() < need.max(HEADER) {
        return Err(MeshFileError::Truncated { have: bytes.len() as u64, need: need as u64 });
    }
    if count == 0 && bytes.len() >= HEADER + RECORD {
        let reason = format!(
            "its header counts no triangles, but {} bytes follow it: whatever wrote it did not \
             finish; export it again",
            bytes.len() - HEADER
        );
        return Err(MeshFileError::Malformed { line: None, reason });
    }
    if count > MAX_TRIANGLES {
        return Err(MeshFileError::TooLarge { count, limit: MAX_TRIANGLES });
    }
    let mut raw = Raw::default();
    for record in bytes[HEADER..need].chunks_exact(RECORD) {
        let mut numbers = record[CORNERS..].chunks_exact(4).map(|number| {
            let number: [u8; 4] = number.try_into().unwrap_or_default();
            f64::from(f32::from_le_bytes(number))
        });
        let base = raw.vertices.len() as u32;
        for _ in 0..3 {
            let mut next = || numbers.next().unwrap_or_default();
            raw.vertices.push(Vec3::new(next(), next(), next()));
        }
        raw.triangles.push([base, base + 1, base + 2]);
    }
    Ok(raw)
}

/// Whether bytes are text: they begin with `solid`, or a facet is near their beginning, and none
/// there is zero.
fn is_text(bytes: &[u8]) -> bool {
    let text = decode(&bytes[..bytes.len().min(BEGINNING)]).to_ascii_lowercase();
    !text.contains('\0') && (text.trim_start().starts_with("solid") || text.contains("facet"))
}

/// What the lines of a text file say, in small or in capital letters.
#[derive(Default)]
struct StlText {
    raw: Raw,
    /// Corners of the facet that is open.
    facet: Option<Vec<u32>>,
    /// Solids that have facets.
    solids: Vec<String>,
    /// The name of the solid that is open, if it has no facet yet.
    begun: Option<String>,
}

fn read_text(text: &str) -> Result<Raw, MeshFileError> {
    let mut stl = StlText { begun: Some(String::new()), ..StlText::default() };
    for (line, text) in lines(text) {
        stl.take(text).map_err(|reason| MeshFileError::Malformed { line: Some(line), reason })?;
        if stl.raw.triangles.len() > MAX_TRIANGLES {
            let count = stl.raw.triangles.len();
            return Err(MeshFileError::TooLarge { count, limit: MAX_TRIANGLES });
        }
    }
    if stl.facet.is_some() {
        let reason = "the file ends within a facet".to_owned();
        return Err(MeshFileError::Malformed { line: None, reason });
    }
    // One solid is the whole file, which has a name already.
    if stl.solids.len() > 1 {
        stl.raw.object_names = apart(stl.solids);
    } else {
        stl.raw.extras = Vec::new();
    }
    Ok(stl.raw)
}

impl StlText {
    fn take(&mut self, line: &str) -> Result<(), String> {
        // All of a facet may be on one line.
        let mut words = line.split_whitespace();
        while let Some(word) = words.next() {
            match word.to_ascii_lowercase().as_str() {
                "solid" => {
                    let name: Vec<&str> = words.by_ref().collect();
                    self.begun = Some(name.join(" "));
                }
                // The name of the solid follows.
                "endsolid" => break,
                "facet" => self.facet = Some(Vec::new()),
                "vertex" => {
                    let mut next = || {
                        let word = words.next().ok_or("a corner has three coordinates")?;
                        number(word)
                    };
                    let corner = Vec3::new(next()?, next()?, next()?);
                    let facet = self.facet.as_mut().ok_or("a corner outside a facet")?;
                    facet.push(self.raw.vertices.len() as u32);
                    self.raw.vertices.push(corner);
                }
                "endfacet" => {
                    let facet = self.facet.take().ok_or("a facet ends that did not begin")?;
                    self.close(&facet);
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn close(&mut self, facet: &[u32]) {
        if facet.len() < 3 {
            self.raw.left_out.add("facet of fewer than three corners");
            return;
        }
        self.solids.extend(self.begun.take());
        let object = self.solids.len().saturating_sub(1) as u32;
        for places in triangles_of(&self.raw.vertices, facet) {
            self.raw.triangles.push(places.map(|k| facet[k as usize]));
            self.raw.extras.push(Extra { object, ..Extra::default() });
        }
    }
}

/// Names that differ: what is there already, or has none, gets a number.
fn apart(names: Vec<String>) -> Vec<String> {
    let mut all: Vec<String> = Vec::with_capacity(names.len());
    for name in names {
        let name = if name.is_empty() { "solid".to_owned() } else { name };
        let mut own = name.clone();
        let mut next = 2;
        while all.contains(&own) {
            own = format!("{name}-{next}");
            next += 1;
        }
        all.push(own);
    }
    all
}
