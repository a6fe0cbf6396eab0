//! The MCAP file under a recording: channels, times, chunks, and getting them onto the disk.

use super::RecordError;
use cullet_proto::recording::{Recorded, schema_of};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Uncompressed bytes a chunk. Large chunks let the compressor see an object's triangles several
/// times (4.3 times smaller than with 1 MiB); larger still, and a seek decompresses too much.
const CHUNK_BYTES: u64 = 8 << 20;

/// One open MCAP file. The zstd encoder runs on this thread: with threads its bytes would differ.
pub(super) struct Sink {
    path: PathBuf,
    file: File,
    writer: mcap::Writer<NoSeek<BufWriter<File>>>,
    channels: BTreeMap<String, (u16, u32)>,
    pending: bool,
    tap: Option<Arc<dyn MessageTap>>,
}

/// Gets each message of a recording as it is written, byte for byte. The run waits for it, so it
/// must not wait for anything itself.
pub trait MessageTap: Debug + Send + Sync {
    /// A channel, before its first message. `schema`: the type of its messages, as a set of
    /// protobuf file descriptors.
    fn channel(&self, topic: &str, schema_name: &str, schema: &[u8]);

    /// A message, with its log time: simulated time \[ns\].
    fn message(&self, topic: &str, log_time: u64, payload: &[u8]);
}

/// Log time and publish time of a message \[ns\].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stamp {
    pub(super) log: u64,
    pub(super) publish: u64,
}

impl Sink {
    pub(super) fn create(
        path: &Path,
        tap: Option<Arc<dyn MessageTap>>,
    ) -> Result<Self, RecordError> {
        let file = File::create(path).map_err(RecordError::io(path))?;
        let copy = file.try_clone().map_err(RecordError::io(path))?;
        let name = concat!("cullet ", env!("CARGO_PKG_VERSION"));
        let writer = mcap::WriteOptions::library(mcap::WriteOptions::new(), name)
            .chunk_size(Some(CHUNK_BYTES))
            .compression_threads(0)
            .disable_seeking(true)
            .create(NoSeek::new(BufWriter::new(copy)))
            .map_err(|source| RecordError::Mcap { path: path.to_owned(), source })?;
        let path = path.to_owned();
        Ok(Self { path, file, writer, channels: BTreeMap::new(), pending: false, tap })
    }

    fn fail(&self) -> impl FnOnce(mcap::McapError) -> RecordError + use<> {
        let path = self.path.clone();
        move |source| RecordError::Mcap { path, source }
    }

    /// Writes a message of ours and hands back its bytes.
    pub(super) fn own<M: Recorded>(
        &mut self,
        topic: &str,
        stamp: Stamp,
        message: &M,
    ) -> Result<Vec<u8>, RecordError> {
        let payload = message.to_bytes();
        self.raw(topic, (M::NAME, || schema_of(M::NAME)), stamp, &payload)?;
        Ok(payload)
    }

    /// Writes a message that viewers know.
    pub(super) fn known<M: foxglove::Encode>(
        &mut self,
        topic: &str,
        stamp: Stamp,
        message: &M,
    ) -> Result<usize, RecordError> {
        let mut payload = Vec::with_capacity(message.encoded_len().unwrap_or_default());
        message.encode(&mut payload).map_err(|error| RecordError::Decode {
            topic: topic.to_owned(),
            log_time: stamp.log,
            reason: error.to_string(),
        })?;
        let schema = M::get_schema();
        let name = schema.as_ref().map(|s| s.name.clone()).unwrap_or_default();
        let data = || schema.map(|s| s.data.into_owned()).unwrap_or_default();
        self.raw(topic, (&name, data), stamp, &payload)?;
        Ok(payload.len())
    }

    fn raw(
        &mut self,
        topic: &str,
        (schema, data): (&str, impl FnOnce() -> Vec<u8>),
        stamp: Stamp,
        payload: &[u8],
    ) -> Result<(), RecordError> {
        if !self.channels.contains_key(topic) {
            let data = data();
            let schema_id =
                self.writer.add_schema(schema, "protobuf", &data).map_err(self.fail())?;
            let id = self
                .writer
                .add_channel(schema_id, topic, "protobuf", &BTreeMap::new())
                .map_err(self.fail())?;
            self.channels.insert(topic.to_owned(), (id, 0));
            self.tap.iter().for_each(|tap| tap.channel(topic, schema, &data));
        }
        let Some((channel_id, sequence)) = self.channels.get_mut(topic) else {
            return Ok(());
        };
        let header = MessageHeader {
            channel_id: *channel_id,
            sequence: *sequence,
            log_time: stamp.log,
            publish_time: stamp.publish,
        };
        *sequence = sequence.wrapping_add(1);
        self.pending = true;
        self.writer.write_to_known_channel(&header, payload).map_err(self.fail())?;
        self.tap.iter().for_each(|tap| tap.message(topic, stamp.log, payload));
        Ok(())
    }

    pub(super) fn attach(
        &mut self,
        name: &str,
        media_type: &str,
        data: &[u8],
    ) -> Result<(), RecordError> {
        let attachment = mcap::Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: data.into(),
        };
        self.writer.attach(&attachment).map_err(self.fail())
    }

    pub(super) fn metadata(
        &mut self,
        name: &str,
        metadata: &BTreeMap<String, String>,
    ) -> Result<(), RecordError> {
        let record = mcap::records::Metadata { name: name.to_owned(), metadata: metadata.clone() };
        self.writer.write_metadata(&record).map_err(self.fail())
    }

    /// Ends the chunk and brings everything so far onto the disk.
    pub(super) fn flush(&mut self) -> Result<(), RecordError> {
        if !self.pending {
            return Ok(());
        }
        self.pending = false;
        self.writer.flush().map_err(self.fail())?;
        self.file.sync_data().map_err(RecordError::io(&self.path))
    }

    /// Writes the indexes and brings the whole file onto the disk.
    pub(super) fn finish(mut self) -> Result<(), RecordError> {
        self.writer.finish().map_err(self.fail())?;
        let mut inner = self.writer.into_inner().into_inner();
        std::io::Write::flush(&mut inner).map_err(RecordError::io(&self.path))?;
        self.file.sync_all().map_err(RecordError::io(&self.path))
    }
}
