//! The records of a file as they lie there, one after another.

use super::found::Found;
use super::holes::{GONE, HOLE};
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader};

/// Bytes of a record's own header: opcode and length.
pub(super) const RECORD_HEADER: usize = 9;

/// Opcode and body of the next whole record, and what follows it.
pub(super) fn next_record(rest: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (head, tail) = rest.split_at_checked(RECORD_HEADER)?;
    let length = u64::from_le_bytes(head[1..].try_into().ok()?);
    let (body, next) = tail.split_at_checked(usize::try_from(length).ok()?)?;
    Some((head[0], body, next))
}

/// Hands each record that a reader finds in `bytes` to `take`; nothing if one of the two refuses.
pub(super) fn read_with(
    mut reader: LinearReader,
    mut bytes: &[u8],
    take: &mut dyn FnMut(u8, &[u8]) -> Option<()>,
) -> Option<()> {
    while let Some(event) = reader.next_event() {
        match event.ok()? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (now, later) = bytes.split_at(wanted.min(bytes.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                bytes = later;
            }
            LinearReadEvent::Record { data, opcode } => take(opcode, data)?,
        }
    }
    Some(())
}

pub(super) fn content(record: Record<'_>) -> Option<Found> {
    match record {
        Record::Schema { header, data } => Some(Found::Schema(header, data.into_owned())),
        Record::Channel(channel) => Some(Found::Channel(channel)),
        Record::Message { header, data } => Some(Found::Message(header, data.into_owned(), None)),
        Record::Attachment { header, data, .. } => {
            Some(Found::Attachment(header, data.into_owned()))
        }
        Record::Metadata(metadata) if metadata.name == HOLE => Some(Found::Hole),
        Record::Metadata(metadata) if metadata.name == GONE => {
            let number = |(topic, number): (String, String)| Some((topic, number.parse().ok()?));
            Some(Found::Gone(metadata.metadata.into_iter().filter_map(number).collect()))
        }
        Record::Metadata(metadata) => Some(Found::Metadata(metadata)),
        _ => None,
    }
}
