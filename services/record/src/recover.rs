//! Making a readable file of one that was cut off.

use super::found::Found;
use super::holes::{GONE, HOLE};
use super::read::{load, walk};
use super::{Holes, RecordError};
use cullet_files::claim;
use mcap::write::NoSeek;
use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};

/// What was saved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recovery {
    /// The file that was read.
    pub from: PathBuf,
    /// The readable file.
    pub to: PathBuf,
    /// True if nothing was missing.
    pub complete: bool,
    /// Whole, intact chunks.
    pub chunks: u64,
    /// Chunks and records that were there but damaged, and left out.
    pub damaged: u64,
    /// Messages copied.
    pub messages: u64,
    /// Attachments copied.
    pub attachments: u64,
    /// Bytes at the end that were part of no whole record.
    pub lost_bytes: u64,
    /// What is missing, which the readable file remembers.
    pub holes: Holes,
}

impl fmt::Display for Recovery {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { chunks, messages, attachments, lost_bytes, holes, .. } = self;
        write!(
            f,
            "{}: {messages} messages of {chunks} chunks, {attachments} attachments; ",
            self.to.display()
        )?;
        match (self.complete, holes.is_empty()) {
            (true, _) => write!(f, "nothing was missing"),
            (false, true) => write!(f, "{lost_bytes} bytes at the end were not whole"),
            _ => write!(f, "it has holes: {holes}; {lost_bytes} bytes at the end were not whole"),
        }
    }
}

/// What the name of a file ends with while it is recovered; whoever writes it has a claim to it.
const UNFINISHED: &str = "recovering";

/// Deletes what recoveries that were killed have left in a folder.
fn clear_left(folder: &Path) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()) {
        if path.extension().is_some_and(|end| end == UNFINISHED) {
            claim::clear(&path);
        }
    }
}

/// Copies every intact chunk, attachment and metadata record of `from` into `to`, with indexes and
/// a mark where a part was damaged. `to` appears only when it is whole; what recoveries that were
/// killed have left in its folder is deleted.
///
/// # Errors
/// `from` cannot be read, is no recording, or has nothing that is not damaged; `to` cannot be
/// written.
pub fn recover(from: &Path, to: &Path) -> Result<Recovery, RecordError> {
    let (from, bytes) = load(from)?;
    let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty());
    clear_left(folder.unwrap_or(Path::new(".")));
    let mut unfinished = to.file_name().unwrap_or_default().to_owned();
    unfinished.push(".");
    unfinished.push(UNFINISHED);
    let unfinished = to.with_file_name(unfinished);
    let mut copy = Copy::create(&unfinished)?;
    let walk = walk(&from, &bytes, &mut |found| copy.take(found));
    let saved = copy.messages + copy.attachments;
    let walk = walk.and_then(|walk| match walk.damaged {
        damaged @ 1.. if saved == 0 => Err(RecordError::Lost { path: from.clone(), damaged }),
        _ => Ok(walk),
    });
    let walk = match walk {
        Ok(walk) => walk,
        Err(error) => {
            // While it is locked: after that another recovery may have it.
            std::fs::remove_file(&unfinished).map_err(RecordError::io(&unfinished))?;
            drop(copy);
            return Err(error);
        }
    };
    let (messages, attachments) = (copy.messages, copy.attachments);
    copy.finish()?;
    std::fs::rename(&unfinished, to).map_err(RecordError::io(to))?;
    Ok(Recovery {
        from,
        to: to.to_owned(),
        complete: walk.ended && walk.holes.is_empty(),
        chunks: walk.chunks,
        damaged: walk.damaged,
        messages,
        attachments,
        lost_bytes: walk.lost_bytes,
        holes: walk.holes,
    })
}

/// The file being made.
struct Copy {
    path: PathBuf,
    file: File,
    writer: mcap::Writer<NoSeek<BufWriter<File>>>,
    /// The writer's numbers for the numbers in the file.
    schemas: BTreeMap<u16, u16>,
    channels: BTreeMap<u16, u16>,
    /// Whether a message was left out because its topic is not known.
    nameless: bool,
    messages: u64,
    attachments: u64,
}

impl Copy {
    fn create(path: &Path) -> Result<Self, RecordError> {
        let file = claim::create(path).map_err(|error| {
            let taken = error.kind() == ErrorKind::AlreadyExists;
            let busy = "another recovery writes it now; wait for it, or recover to another file";
            let error = if taken { std::io::Error::new(error.kind(), busy) } else { error };
            RecordError::io(path)(error)
        })?;
        let buffer = BufWriter::new(file.try_clone().map_err(RecordError::io(path))?);
        let name = concat!("cullet ", env!("CARGO_PKG_VERSION"), " recover");
        let writer = mcap::WriteOptions::library(mcap::WriteOptions::new(), name)
            .chunk_size(None)
            .compression_threads(0)
            .disable_seeking(true)
            .create(NoSeek::new(buffer))
            .map_err(|source| RecordError::Mcap { path: path.to_owned(), source })?;
        Ok(Self {
            path: path.to_owned(),
            file,
            writer,
            schemas: BTreeMap::from([(0, 0)]),
            channels: BTreeMap::new(),
            nameless: false,
            messages: 0,
            attachments: 0,
        })
    }

    fn take(&mut self, found: Found) -> Result<(), RecordError> {
        let path = self.path.clone();
        self.copy(found).map_err(|source| RecordError::Mcap { path, source })
    }

    fn copy(&mut self, found: Found) -> Result<(), mcap::McapError> {
        match found {
            Found::Schema(header, data) => {
                let id = self.writer.add_schema(&header.name, &header.encoding, &data)?;
                self.schemas.insert(header.id, id);
            }
            Found::Channel(channel) => {
                let Some(&schema) = self.schemas.get(&channel.schema_id) else {
                    return Ok(());
                };
                let (topic, encoding) = (&channel.topic, &channel.message_encoding);
                let id = self.writer.add_channel(schema, topic, encoding, &channel.metadata)?;
                self.channels.insert(channel.id, id);
            }
            Found::Message(mut header, data, _) => {
                let Some(&id) = self.channels.get(&header.channel_id) else {
                    // The copy has none of these, and remembers that there were some.
                    let first = !std::mem::replace(&mut self.nameless, true);
                    return if first { self.mark(HOLE, BTreeMap::new()) } else { Ok(()) };
                };
                header.channel_id = id;
                self.writer.write_to_known_channel(&header, &data)?;
                self.messages += 1;
            }
            Found::Attachment(header, data) => {
                self.writer.attach(&mcap::Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data: data.into(),
                })?;
                self.attachments += 1;
            }
            Found::Metadata(metadata) => self.writer.write_metadata(&metadata)?,
            Found::ChunkEnd => self.writer.flush()?,
            Found::Hole => self.mark(HOLE, BTreeMap::new())?,
            Found::Gone(numbers) => {
                let told = numbers.into_iter().map(|(topic, number)| (topic, number.to_string()));
                self.mark(GONE, told.collect())?;
            }
        }
        Ok(())
    }

    /// Writes a metadata record that remembers what is missing.
    fn mark(
        &mut self,
        name: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<(), mcap::McapError> {
        let name = name.to_owned();
        self.writer.write_metadata(&mcap::records::Metadata { name, metadata })
    }

    fn finish(mut self) -> Result<(), RecordError> {
        let path = self.path.clone();
        let fail = |source| RecordError::Mcap { path: path.clone(), source };
        self.writer.finish().map_err(fail)?;
        let mut inner = self.writer.into_inner().into_inner();
        std::io::Write::flush(&mut inner).map_err(RecordError::io(&path))?;
        self.file.sync_all().map_err(RecordError::io(&path))
    }
}
