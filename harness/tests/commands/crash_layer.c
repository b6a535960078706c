/* A Vulkan layer that crashes in the Nth submission of a process, N from CRASH_AT. Only what it needs of the interface is
 * declared here, so that no headers of Vulkan are needed (loader's interface: LoaderLayerInterface.md). */
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef void (*Function)(void);
typedef Function (*Get)(void *, const char *);

typedef struct Link {
    struct Link *next;
    Get instance;
    Get device;
} Link;

typedef struct Info {
    int type;
    struct Info *next;
    int function;
    Link *link;
} Info;

enum { INSTANCE = 47, DEVICE = 48 };

static Get next_instance, next_device;
static void *instance;
static int (*real_submit)(void *, uint32_t, const void *, void *);
static int submissions;

/* The loader's link to the next layer, taken out of the chain for that layer. */
static Link *taken(Info *info, int type) {
    for (; info; info = info->next) {
        if (info->type == type && info->function == 0) {
            Link *link = info->link;
            info->link = link->next;
            return link;
        }
    }
    return NULL;
}

static int create_instance(Info *info, const void *allocator, void **out) {
    Link *link = taken(info->next, INSTANCE);
    next_instance = link->instance;
    int (*create)(Info *, const void *, void **) = (void *)next_instance(NULL, "vkCreateInstance");
    int result = create(info, allocator, out);
    instance = *out;
    return result;
}

static int create_device(void *physical, Info *info, const void *allocator, void **out) {
    Link *link = taken(info->next, DEVICE);
    next_device = link->device;
    int (*create)(void *, Info *, const void *, void **) =
        (void *)link->instance(instance, "vkCreateDevice");
    return create(physical, info, allocator, out);
}

static int submit(void *queue, uint32_t count, const void *submits, void *fence) {
    const char *at = getenv("CRASH_AT");
    if (at && ++submissions == atoi(at)) {
        signal(SIGSEGV, SIG_DFL);
        raise(SIGSEGV);
    }
    return real_submit(queue, count, submits, fence);
}

__attribute__((visibility("default"))) Function vkGetDeviceProcAddr(void *device, const char *name) {
    if (!strcmp(name, "vkGetDeviceProcAddr")) return (Function)vkGetDeviceProcAddr;
    if (!strcmp(name, "vkQueueSubmit")) {
        real_submit = (void *)next_device(device, name);
        return (Function)submit;
    }
    return next_device(device, name);
}

__attribute__((visibility("default"))) Function vkGetInstanceProcAddr(void *of, const char *name) {
    if (!strcmp(name, "vkGetInstanceProcAddr")) return (Function)vkGetInstanceProcAddr;
    if (!strcmp(name, "vkGetDeviceProcAddr")) return (Function)vkGetDeviceProcAddr;
    if (!strcmp(name, "vkCreateInstance")) return (Function)create_instance;
    if (!strcmp(name, "vkCreateDevice")) return (Function)create_device;
    return next_instance ? next_instance(of, name) : NULL;
}
