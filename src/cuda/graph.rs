//! A frame's launches as one CUDA graph: recorded anew every frame, since arguments change with the view, brought into the
//! graph of the last frame, and run at once. Where the driver declines, frames are launched one kernel after the other.

use super::CudaError;
use cudarc::driver::{CudaEvent, CudaStream, result, sys};
use std::mem::MaybeUninit;
use std::sync::Arc;

/// Recordings that may fail before no more are tried.
const MOST_FAILURES: u32 = 3;
/// Events of a recording can be asked for their time afterwards: CU_EVENT_RECORD_EXTERNAL.
const EXTERNAL: u32 = 1;

/// A graph that can be run.
#[derive(Debug)]
struct Runnable(sys::CUgraphExec);

// SAFETY: the driver's graphs are not bound to a thread; this one is used by its owner alone, through `&mut`.
unsafe impl Send for Runnable {}
// SAFETY: nothing is done with it through `&`.
unsafe impl Sync for Runnable {}

impl Drop for Runnable {
    fn drop(&mut self) {
        // SAFETY: it was made by `instantiate`, and is destroyed once; what runs of it still ends.
        let _ = unsafe { result::graph::exec_destroy(self.0) };
    }
}

/// What is recorded of a stream.
#[derive(Debug, Default)]
pub(super) struct Graph {
    runnable: Option<Runnable>,
    recording: bool,
    failures: u32,
    /// Events are the same from frame to frame, so that a graph's last frame fits the next one.
    events: Vec<Arc<CudaEvent>>,
    used: usize,
}

impl Graph {
    pub fn is_recording(&self) -> bool {
        self.recording
    }

    /// From here on launches are recorded, not run.
    pub fn begin(&mut self, stream: &CudaStream) -> Result<(), CudaError> {
        if self.failures < MOST_FAILURES {
            let mode = sys::CUstreamCaptureMode::CU_STREAM_CAPTURE_MODE_THREAD_LOCAL;
            stream.begin_capture(mode).map_err(CudaError::of_driver("recording a CUDA graph"))?;
            (self.recording, self.used) = (true, 0);
        }
        Ok(())
    }

    /// The point after everything that has been recorded.
    pub fn mark(&mut self, stream: &CudaStream) -> Result<Arc<CudaEvent>, CudaError> {
        let failed = || CudaError::of_driver("recording a CUDA event");
        if self.used == self.events.len() {
            let event = stream.context().new_event(Some(sys::CUevent_flags::CU_EVENT_DEFAULT));
            self.events.push(Arc::new(event.map_err(failed())?));
        }
        let event = self.events[self.used].clone();
        self.used += 1;
        // SAFETY: both live, and belong to one context.
        let recorded = unsafe { sys::cuEventRecordWithFlags(event.cu_event(), stream.cu_stream(), EXTERNAL) };
        recorded.result().map_err(failed())?;
        Ok(event)
    }

    /// Runs what was recorded.
    pub fn run(&mut self, stream: &CudaStream) -> Result<(), CudaError> {
        if !self.recording {
            return Ok(());
        }
        self.recording = false;
        let failed = || CudaError::of_driver("running a CUDA graph");
        // SAFETY: `begin` began to record this stream.
        let graph = unsafe { result::stream::end_capture(stream.cu_stream()) }.map_err(failed())?;
        let ran = self.run_graph(stream, graph);
        // SAFETY: it was made by `end_capture`; graphs that can be run do not need it.
        let destroyed = unsafe { result::graph::destroy(graph) };
        ran.and(destroyed).map_err(failed())
    }

    fn run_graph(&mut self, stream: &CudaStream, graph: sys::CUgraph) -> Result<(), cudarc::driver::DriverError> {
        if let Some(Runnable(old)) = &self.runnable {
            let mut told = MaybeUninit::uninit();
            // SAFETY: both graphs live; the old one has been run to its end, or is updated for later runs alone.
            if unsafe { sys::cuGraphExecUpdate_v2(*old, graph, told.as_mut_ptr()) }.result().is_err() {
                self.runnable = None;
            }
        }
        let runnable = match &self.runnable {
            Some(Runnable(runnable)) => *runnable,
            None => {
                // SAFETY: the graph was made by `end_capture`.
                let new = unsafe { result::graph::instantiate(graph, sys::CUgraphInstantiate_flags(0)) }?;
                self.runnable.insert(Runnable(new)).0
            }
        };
        // SAFETY: the stream lives; the graph's buffers do until the frame's end.
        unsafe { result::graph::launch(runnable, stream.cu_stream()) }
    }

    /// A frame that failed: nothing of it is run.
    pub fn abandon(&mut self, stream: &CudaStream) {
        if self.recording {
            self.recording = false;
            self.failures += 1;
            // SAFETY: `begin` began to record this stream.
            let graph = unsafe { result::stream::end_capture(stream.cu_stream()) };
            // A broken recording has none.
            if let Some(graph) = graph.ok().filter(|graph| !graph.is_null()) {
                // SAFETY: it was made by `end_capture`.
                let _ = unsafe { result::graph::destroy(graph) };
            }
        }
    }
}
