//! Longer-lived descriptor sets. The resources of a scene or object are written once, and bound as a whole.
//!
//! [`Commands::bind`] pushes set 0 of every pipeline. Sets 1 and 2 are [`ResourceSet`]s. All pipelines that use one of these sets
//! have the same layout for it.

use std::any::Any;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use ash::vk;

use super::bind::{Descriptor, in_order, write};
use super::error::Doing;
use super::shaders::{ResourceKind, descriptor_type};
use super::{Commands, DriverCall, Gpu, GpuError, Result};

/// The number of sets of a pipeline. One set is pushed, and two sets are longer-lived.
pub(crate) const SETS: usize = 3;

const POOL_SETS: u32 = 64;

/// The layout of a set, as a list of the names and kinds of the resources that GLSL declares with `layout(set = number)`. The
/// binding number of a resource is its index in the list.
#[derive(Debug)]
pub struct SetLayout {
    /// The number of the set, 1 or 2.
    pub number: u32,
    /// The name of the set's owner, for messages.
    pub name: &'static str,
    /// The names and kinds of the set's resources.
    pub resources: &'static [(&'static str, ResourceKind)],
}

impl SetLayout {
    pub(crate) fn binding(&self, name: &str) -> Option<u32> {
        self.resources.iter().position(|(known, _)| *known == name).map(|index| index as u32)
    }
}

/// The set layouts of a device, and the descriptor pools for new sets.
pub(crate) struct SetLayouts {
    all: Vec<&'static SetLayout>,
    made: Mutex<Vec<Known>>,
}

struct Known {
    layout: &'static SetLayout,
    raw: vk::DescriptorSetLayout,
    /// The pool of the next set. `left` counts the free sets in the pool.
    pool: Weak<SetPool>,
    left: u32,
}

impl SetLayouts {
    pub(crate) fn new(all: Vec<&'static SetLayout>) -> Self {
        Self { all, made: Mutex::default() }
    }

    /// Returns the layout of the sets with this number.
    pub(crate) fn numbered(&self, number: u32) -> Option<&'static SetLayout> {
        self.all.iter().copied().find(|layout| layout.number == number)
    }

    /// Returns the Vulkan object for a layout. The device owns the object.
    pub(crate) fn raw(&self, gpu: &Gpu, layout: &'static SetLayout) -> Result<vk::DescriptorSetLayout> {
        self.with(gpu, layout, |known| Ok(known.raw))
    }

    fn with<R>(&self, gpu: &Gpu, layout: &'static SetLayout, then: impl FnOnce(&mut Known) -> Result<R>) -> Result<R> {
        let mut all = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let index = match all.iter().position(|known| std::ptr::eq(known.layout, layout)) {
            Some(index) => index,
            None => {
                all.push(Known { layout, raw: create(gpu, layout)?, pool: Weak::new(), left: 0 });
                all.len() - 1
            }
        };
        then(&mut all[index])
    }

    /// Destroys the layouts.
    ///
    /// # Safety
    /// No pipeline and no set of this device may exist any more.
    pub(crate) unsafe fn destroy(&self, device: &ash::Device) {
        for known in self.made.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
            // SAFETY: the caller ensures that nothing uses the layout.
            unsafe { device.destroy_descriptor_set_layout(known.raw, None) };
        }
    }
}

fn create(gpu: &Gpu, layout: &SetLayout) -> Result<vk::DescriptorSetLayout> {
    let resources = layout.resources.iter().map(|(_, kind)| (*kind, vk::ShaderStageFlags::ALL));
    descriptor_layout(gpu, layout.name, vk::DescriptorSetLayoutCreateFlags::empty(), resources)
}

/// Creates a descriptor set layout for these resources and stages, and numbers the resources in order. The caller must destroy it.
pub(crate) fn descriptor_layout(
    gpu: &Gpu,
    name: &str,
    flags: vk::DescriptorSetLayoutCreateFlags,
    resources: impl Iterator<Item = (ResourceKind, vk::ShaderStageFlags)>,
) -> Result<vk::DescriptorSetLayout> {
    let binding = |(number, (kind, stages))| {
        vk::DescriptorSetLayoutBinding::default()
            .binding(number)
            .descriptor_type(descriptor_type(kind))
            .descriptor_count(1)
            .stage_flags(stages)
    };
    let bindings: Vec<_> = (0u32..).zip(resources).map(binding).collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().flags(flags).bindings(&bindings);
    // SAFETY: the device is alive, and `bindings` outlives the call.
    let raw = unsafe { gpu.raw().create_descriptor_set_layout(&info, None) }
        .doing(format!("creating the descriptor layout of {name}"))?;
    gpu.name(raw, name);
    Ok(raw)
}

/// A pool of sets that have one layout. All sets are freed together when the last set is dropped.
struct SetPool {
    gpu: Arc<Gpu>,
    raw: vk::DescriptorPool,
}

impl Drop for SetPool {
    fn drop(&mut self) {
        // SAFETY: commands that use a set of the pool hold the set until they are done.
        unsafe { self.gpu.raw().destroy_descriptor_pool(self.raw, None) };
    }
}

impl SetPool {
    fn new(gpu: &Arc<Gpu>, layout: &SetLayout) -> Result<Arc<Self>> {
        let size = |kind: ResourceKind| {
            let count = layout.resources.iter().filter(|(_, other)| *other == kind).count() as u32;
            vk::DescriptorPoolSize::default().ty(descriptor_type(kind)).descriptor_count(count * POOL_SETS)
        };
        let mut sizes = ResourceKind::ALL.map(size).to_vec();
        sizes.retain(|size| size.descriptor_count > 0);
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(POOL_SETS).pool_sizes(&sizes);
        let made = gpu.faults().check(DriverCall::Allocation);
        // SAFETY: the device is alive, and `sizes` outlives the call.
        let made = made.and_then(|()| unsafe { gpu.raw().create_descriptor_pool(&info, None) });
        let raw = made.doing(format!("creating a pool of sets {}", layout.name))?;
        Ok(Arc::new(Self { gpu: gpu.clone(), raw }))
    }
}

impl Known {
    /// Allocates a set from the current pool or from a new pool.
    fn take(&mut self, gpu: &Arc<Gpu>) -> Result<(Arc<SetPool>, vk::DescriptorSet)> {
        let pool = match self.pool.upgrade().filter(|_| self.left > 0) {
            Some(pool) => pool,
            None => {
                let pool = SetPool::new(gpu, self.layout)?;
                (self.pool, self.left) = (Arc::downgrade(&pool), POOL_SETS);
                pool
            }
        };
        let layouts = [self.raw];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool.raw).set_layouts(&layouts);
        // SAFETY: pool and layout are alive, the lock of `SetLayouts` is held, and the pool has room for another set.
        let sets = unsafe { gpu.raw().allocate_descriptor_sets(&info) };
        let set = sets.doing(format!("allocating a set {}", self.layout.name))?[0];
        self.left -= 1;
        Ok((pool, set))
    }
}

/// Resources that are bound together. Clones share the same resources.
#[derive(Clone)]
pub struct ResourceSet {
    inner: Arc<SetInner>,
}

struct SetInner {
    layout: &'static SetLayout,
    raw: vk::DescriptorSet,
    _pool: Arc<SetPool>,
    _resources: Vec<Arc<dyn Any + Send + Sync>>,
}

impl ResourceSet {
    /// Creates an immutable set with all resources of a layout. The set keeps the resources alive.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if a resource is missing, given twice, of the wrong kind, or not in the layout.
    pub fn new(gpu: &Arc<Gpu>, layout: &'static SetLayout, resources: &[(&str, Descriptor<'_>)]) -> Result<Self> {
        let stranger = |name: &str| format!("its set has no resource {name}");
        let descriptors = in_order(layout.name, layout.resources.iter().copied(), resources, |_| false, stranger)?;
        let mut kept = Vec::new();
        let infos: Vec<_> =
            descriptors.iter().map(|given| (given.kind(), given.info(&mut |it| kept.push(it)))).collect();
        let (pool, raw) = gpu.set_layouts().with(gpu, layout, |known| known.take(gpu))?;
        let writes: Vec<_> =
            (0u32..).zip(&infos).map(|(number, (kind, info))| write(number, *kind, info).dst_set(raw)).collect();
        // SAFETY: the set is new, so nothing uses it, and `kept` holds what the writes refer to.
        unsafe { gpu.raw().update_descriptor_sets(&writes, &[]) };
        Ok(Self { inner: Arc::new(SetInner { layout, raw, _pool: pool, _resources: kept }) })
    }
}

impl Commands {
    /// Binds a set until another pipeline is bound. A set that the pipeline does not use has no effect.
    pub fn bind_set(&mut self, set: &ResourceSet) {
        let SetInner { layout, raw, .. } = &*set.inner;
        let Some(core) = self.pipeline.clone() else {
            return self.fail(GpuError::usage(layout.name, "its set was given before a pipeline was bound"));
        };
        let Some(known) = core.sets.get(layout.number as usize).copied().flatten() else { return };
        if !std::ptr::eq(known, *layout) {
            let fault = format!("its set {} is {}, not {}", layout.number, known.name, layout.name);
            return self.fail(GpuError::usage(&core.name, fault));
        }
        self.keep(&set.inner);
        self.bound |= 1 << layout.number;
        // SAFETY: the command buffer is being recorded, and the pipeline's layout has this layout at this index.
        unsafe {
            let device = self.gpu().raw();
            device.cmd_bind_descriptor_sets(self.raw(), core.bind_point, core.layout(), layout.number, &[*raw], &[]);
        }
    }
}
