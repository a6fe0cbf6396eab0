//! The end of a file: what it says of all that is before it.

use super::found::Found;
use super::raw_records::{RECORD_HEADER, content, next_record, read_with};
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;

/// Bytes of the footer, which is the last record of a file.
const FOOTER: usize = RECORD_HEADER + 20;
/// Bytes of the record between the data and the summary.
const DATA_END: usize = RECORD_HEADER + 4;

/// What is at a place in a file.
pub(super) enum EndStep {
    /// A record with this opcode, up to there.
    Record(u8, usize),
    /// One that is not what was written, if the end of the file is right; the next one is there.
    Damaged(usize),
}

/// What the end of a file says.
#[derive(Default)]
pub(super) struct End {
    /// The schemas and channels of the file.
    pub(super) channels: Vec<Found>,
    /// How many messages each channel has; nothing where the end is damaged itself.
    pub(super) counts: Option<BTreeMap<u16, u64>>,
    /// Opcodes and ends of chunks, attachments, metadata and the last record of the data, by where
    /// they begin; none where the end is damaged, or what is before it has not its length.
    places: BTreeMap<usize, (u8, usize)>,
}

impl End {
    pub(super) fn of(bytes: &[u8]) -> Self {
        let start = summary_start(bytes);
        let summary = start.and_then(|start| Some((start, bytes.get(start..)?)));
        if let Some((start, summary)) = summary.filter(|(_, summary)| is_sound(summary)) {
            return Self { places: places(summary, start - DATA_END), ..Self::read(summary, true) };
        }
        let mut rest = bytes.strip_prefix(mcap::MAGIC).unwrap_or_default();
        while let Some((opcode, _, next)) = next_record(rest) {
            rest = next;
            if opcode == op::DATA_END {
                return Self::read(rest, is_sound(rest));
            }
        }
        Self::default()
    }

    fn read(summary: &[u8], is_sound: bool) -> Self {
        let mut end = Self::default();
        for record in records(summary) {
            match record {
                Record::Schema { .. } | Record::Channel(_) => end.channels.extend(content(record)),
                Record::Statistics(all) if is_sound => {
                    end.counts = Some(all.channel_message_counts);
                }
                _ => {}
            }
        }
        end
    }

    /// Where the data end, if that is known.
    pub(super) fn data_end(&self) -> Option<usize> {
        self.places.values().map(|(_, end)| *end).next_back()
    }

    /// What is at a place where a record begins; nothing where no whole one does.
    pub(super) fn step(&self, bytes: &[u8], at: usize) -> Option<EndStep> {
        let read = next_record(bytes.get(at..)?);
        let read = read.map(|(opcode, body, _)| (opcode, at + RECORD_HEADER + body.len()));
        let record = |(opcode, end)| EndStep::Record(opcode, end);
        match self.places.range(at..).next() {
            None => read.map(record),
            Some((&start, &meant)) if start == at => Some(match read {
                Some(read) if read == meant => record(read),
                _ => EndStep::Damaged(meant.1),
            }),
            Some((&start, _)) => Some(match read {
                Some(read) if read.1 <= start => record(read),
                _ => EndStep::Damaged(start),
            }),
        }
    }
}

/// Whether a file ends as a finished one does.
pub(super) fn has_end(bytes: &[u8]) -> bool {
    bytes.len() > 2 * mcap::MAGIC.len() && bytes.ends_with(mcap::MAGIC)
}

/// Where the footer says that the summary begins.
fn summary_start(bytes: &[u8]) -> Option<usize> {
    let footer = bytes.len().checked_sub(mcap::MAGIC.len() + FOOTER)?;
    let (opcode, body, _) = next_record(&bytes[footer..])?;
    let Ok(Record::Footer(told)) = mcap::parse_record(opcode, body) else { return None };
    let least = mcap::MAGIC.len() + DATA_END;
    usize::try_from(told.summary_start).ok().filter(|start| (least..footer).contains(start))
}

/// Whether a summary is what was written, by its check sum. `summary`: all up to the end of the
/// file.
fn is_sound(summary: &[u8]) -> bool {
    // The reader begins the sum where the data end.
    let mut bytes = vec![op::DATA_END, 4];
    bytes.resize(DATA_END, 0);
    bytes.extend_from_slice(summary);
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_emit_chunks(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(bytes.len());
    let reader = LinearReader::new_with_options(options);
    has_end(&bytes) && read_with(reader, &bytes, &mut |_, _| Some(())).is_some()
}

fn records(mut rest: &[u8]) -> impl Iterator<Item = Record<'_>> {
    let all = std::iter::from_fn(move || {
        let (opcode, body, next) = next_record(rest)?;
        rest = next;
        Some(mcap::parse_record(opcode, body).ok())
    });
    all.flatten()
}

/// The places that a summary names, of which none overlaps another or what is at `data_end`.
fn places(summary: &[u8], data_end: usize) -> BTreeMap<usize, (u8, usize)> {
    let mut named = BTreeMap::new();
    for record in records(summary) {
        let (opcode, start, length) = match record {
            Record::ChunkIndex(of) => (op::CHUNK, of.chunk_start_offset, of.chunk_length),
            Record::AttachmentIndex(of) => (op::ATTACHMENT, of.offset, of.length),
            Record::MetadataIndex(of) => (op::METADATA, of.offset, of.length),
            _ => continue,
        };
        let end = start.checked_add(length).and_then(|end| usize::try_from(end).ok());
        if let (Ok(start), Some(end)) = (usize::try_from(start), end) {
            named.insert(start, (opcode, end));
        }
    }
    let mut last = mcap::MAGIC.len();
    named.retain(|start, (_, end)| {
        let fits = last <= *start && start + RECORD_HEADER <= *end && *end <= data_end;
        last = if fits { *end } else { last };
        fits
    });
    named.insert(data_end, (op::DATA_END, data_end + DATA_END));
    named
}
