//! Records, submits and reuses command buffers, with or without semaphores, and waits for them.

use std::any::Any;
use std::sync::Arc;

use ash::vk;

use super::commands::Recorded;
use super::error::Doing;
use super::{Commands, DriverCall, Gpu, GpuError, Result};

impl Gpu {
    /// Records commands, submits them and waits until they are done. Captures and messages show the commands under the name
    /// `label`. The commands see all writes of earlier submissions, and later submissions see all writes of the commands.
    ///
    /// # Errors
    /// Returns an error for the first misuse during recording, or for a failed Vulkan call. After a misuse, nothing is submitted.
    pub fn submit<R>(self: &Arc<Self>, label: &str, record: impl FnOnce(&mut Commands) -> R) -> Result<R> {
        let mut recorder = CommandRecorder::new(self, label)?;
        let result = recorder.record(label, |cmd| {
            cmd.full_barrier();
            let result = record(cmd);
            cmd.full_barrier();
            result
        })?;
        recorder.submit(&[], &[])?;
        recorder.wait()?;
        Ok(result)
    }
}

/// A reusable command buffer. A window needs one per frame in flight.
///
/// `record` waits for the previous submission, so at most one submission is in progress. Each recording is submitted at most once.
/// The tracked state of images and timestamps changes at submission, not during recording.
pub struct CommandRecorder {
    gpu: Arc<Gpu>,
    pool: vk::CommandPool,
    buffer: vk::CommandBuffer,
    fence: vk::Fence,
    state: State,
    name: String,
    /// The objects that are kept alive until the commands are done.
    keep: Vec<Arc<dyn Any + Send + Sync>>,
}

enum State {
    /// There is nothing to submit.
    Idle,
    /// Commands are ready to be submitted.
    Recorded(Recorded),
    /// Commands were submitted.
    Pending,
}

impl CommandRecorder {
    /// Creates a recorder. Captures and messages show it under the name `name`.
    pub fn new(gpu: &Arc<Gpu>, name: &str) -> Result<Self> {
        let mut recorder = Self {
            gpu: gpu.clone(),
            pool: vk::CommandPool::null(),
            buffer: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            state: State::Idle,
            name: name.to_owned(),
            keep: Vec::new(),
        };
        let device = gpu.raw();
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(gpu.queue_family());
        // SAFETY: the device is alive; dropping the recorder destroys what was created.
        recorder.pool = unsafe { device.create_command_pool(&info, None) }.doing("creating a command pool")?;
        gpu.name(recorder.pool, name);
        // SAFETY: the device is alive; dropping the recorder destroys the fence.
        recorder.fence =
            unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }.doing("creating a fence")?;
        gpu.name(recorder.fence, name);
        let info = vk::CommandBufferAllocateInfo::default().command_pool(recorder.pool).command_buffer_count(1);
        let labels = gpu.lock_labels();
        // SAFETY: the pool was made above, on this device.
        let buffers = unsafe { device.allocate_command_buffers(&info) };
        drop(labels);
        recorder.buffer = buffers.doing("creating a command buffer")?[0];
        gpu.name(recorder.buffer, name);
        Ok(recorder)
    }

    /// Waits for the previous submission and starts a new recording.
    ///
    /// # Errors
    /// Returns an error for the first misuse during recording, or for a failed Vulkan call.
    pub fn record<R>(&mut self, label: &str, record: impl FnOnce(&mut Commands) -> R) -> Result<R> {
        self.wait()?;
        let device = self.gpu.raw();
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        self.state = State::Idle;
        let labels = self.gpu.lock_labels();
        // SAFETY: the previous submission is done, so the pool may be reset and its buffer may be recorded.
        unsafe {
            device
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .doing(format!("resetting {}", self.name))?;
            device.begin_command_buffer(self.buffer, &info).doing(format!("recording {label}"))?;
        }
        drop(labels);
        let mut commands = Commands::new(&self.gpu, self.buffer);
        let result = commands.label(label, record);
        let recorded = commands.finish()?;
        // SAFETY: recording began above.
        unsafe { device.end_command_buffer(self.buffer) }.doing(format!("recording {label}"))?;
        self.state = State::Recorded(recorded);
        Ok(result)
    }

    /// Submits the recorded commands without waiting for them. The commands wait for each semaphore of `waits` at its stages, and
    /// signal each semaphore of `signals` after its stages.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if nothing was recorded since the last submission. After a failed submission, for example on a
    /// lost device, nothing is left to submit.
    pub fn submit(
        &mut self,
        waits: &[(vk::Semaphore, vk::PipelineStageFlags2)],
        signals: &[(vk::Semaphore, vk::PipelineStageFlags2)],
    ) -> Result<()> {
        let mut recorded = match std::mem::replace(&mut self.state, State::Idle) {
            State::Recorded(recorded) => recorded,
            other => {
                self.state = other;
                let fault = "nothing was recorded since the last submission: record first";
                return Err(GpuError::usage(&self.name, fault));
            }
        };
        let info = |(semaphore, stages): &(vk::Semaphore, vk::PipelineStageFlags2)| {
            vk::SemaphoreSubmitInfo::default().semaphore(*semaphore).stage_mask(*stages)
        };
        let waits: Vec<_> = waits.iter().map(info).collect();
        let signals: Vec<_> = signals.iter().map(info).collect();
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(self.buffer)];
        let submission = vk::SubmitInfo2::default()
            .wait_semaphore_infos(&waits)
            .command_buffer_infos(&buffers)
            .signal_semaphore_infos(&signals);
        let queue = self.gpu.queue();
        self.gpu
            .faults()
            .check(DriverCall::Submission)
            // SAFETY: in this state, the buffer was recorded and not submitted since, so the fence is unsignalled and in no other
            // submission. The queue is locked.
            .and_then(|()| unsafe { self.gpu.raw().queue_submit2(*queue, &[submission], self.fence) })
            .doing(format!("submitting {}", self.name))?;
        recorded.effects.commit();
        self.keep = recorded.keep;
        self.state = State::Pending;
        Ok(())
    }

    /// Whether commands were submitted and nothing has waited for them yet.
    pub fn is_pending(&self) -> bool {
        matches!(self.state, State::Pending)
    }

    /// Waits for the pending submission, if there is one, and releases its objects.
    pub fn wait(&mut self) -> Result<()> {
        if self.is_pending() {
            // SAFETY: the fence belongs to a submission in progress. After the wait, nothing uses the fence.
            unsafe {
                self.gpu
                    .raw()
                    .wait_for_fences(&[self.fence], true, u64::MAX)
                    .and_then(|()| self.gpu.faults().check(DriverCall::Wait))
                    .doing(format!("waiting for {}", self.name))?;
                self.gpu.raw().reset_fences(&[self.fence]).doing("resetting a fence")?;
            }
            self.state = State::Idle;
            self.keep.clear();
        }
        Ok(())
    }
}

impl Drop for CommandRecorder {
    fn drop(&mut self) {
        if let Err(error) = self.wait()
            && !error.is_lost_device()
            && self.gpu.wait_idle().is_err()
        {
            // The wait failed, but the device is not lost and may still use these objects, so they are leaked.
            std::mem::forget(std::mem::take(&mut self.keep));
            return;
        }
        let _labels = self.gpu.lock_labels();
        // SAFETY: no submission is in progress, or the device is lost; null handles are ignored.
        unsafe {
            self.gpu.raw().destroy_fence(self.fence, None);
            self.gpu.raw().destroy_command_pool(self.pool, None);
        }
    }
}
