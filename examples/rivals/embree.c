/* Answers rays by Embree 4, so that `exact` can be timed against it: embree.sh compiles and runs this.
 *
 *   embree LIBRARY FOLDER THREADS
 *
 * LIBRARY is libembree4.so, opened while the program runs: nothing of Embree is needed to compile it. FOLDER holds what
 * embree.rs writes. After one line that names the library, the program answers each line it reads with one line:
 *
 *   build    builds the hierarchy over the triangles anew; the answer is how long that took, milliseconds
 *   trace    traces all rays and writes FOLDER/hidden.u8, a byte a pixel; the answer is how long tracing alone took, milliseconds
 *
 * Embree is used as its manual advises for speed: packets of eight rays, the flag for coherent rays, denormal numbers taken for
 * zero, scene flags and build quality as they are by default. */

#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <xmmintrin.h>

/* The part of Embree 4's interface that is used here, after its manual. */

enum { BUFFER_INDEX = 0, BUFFER_VERTEX = 1, GEOMETRY_TRIANGLE = 0 };
enum { FORMAT_UINT3 = 0x5003, FORMAT_FLOAT3 = 0x9003 };
enum { QUERY_COHERENT = 1 << 16, FEATURES_ALL = -1 };
enum { PROPERTY_VERSION = 0, PROPERTY_RAY16 = 34 };

/* Eight rays; those that are hidden come back with `tfar` at minus infinity. */
struct rays {
    float origin[3][8], tnear[8], direction[3][8], time[8], tfar[8];
    uint32_t mask[8], id[8], flags[8];
} __attribute__((aligned(32)));

struct occluded_arguments {
    int flags;
    int features;
    void *context, *filter, *user_geometry;
    /* Only there in some builds of the library: zero is its default. */
    float min_width;
};

static void *(*new_device)(const char *);
static ssize_t (*device_property)(void *, int);
static int (*device_error)(void *);
static void *(*new_scene)(void *);
static void (*release_scene)(void *);
static void *(*new_geometry)(void *, int);
static void *(*new_buffer)(void *, int, unsigned, int, size_t, size_t);
static void (*commit_geometry)(void *);
static unsigned (*attach_geometry)(void *, void *);
static void (*release_geometry)(void *);
static void (*commit_scene)(void *);
static void (*occluded8)(const int *, void *, struct rays *, struct occluded_arguments *);

static void fail(const char *what, const char *why) {
    fprintf(stderr, "embree.c: %s: %s\n", what, why);
    exit(1);
}

static void *symbol(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) fail(name, "is not in the library");
    return found;
}

static void open_library(const char *path) {
    void *library = dlopen(path, RTLD_NOW);
    if (!library) fail(path, dlerror());
    new_device = symbol(library, "rtcNewDevice");
    device_property = symbol(library, "rtcGetDeviceProperty");
    device_error = symbol(library, "rtcGetDeviceError");
    new_scene = symbol(library, "rtcNewScene");
    release_scene = symbol(library, "rtcReleaseScene");
    new_geometry = symbol(library, "rtcNewGeometry");
    new_buffer = symbol(library, "rtcSetNewGeometryBuffer");
    commit_geometry = symbol(library, "rtcCommitGeometry");
    attach_geometry = symbol(library, "rtcAttachGeometry");
    release_geometry = symbol(library, "rtcReleaseGeometry");
    commit_scene = symbol(library, "rtcCommitScene");
    occluded8 = symbol(library, "rtcOccluded8");
}

/* What is in the folder. */

static size_t vertex_count, triangle_count, width, height;
static void *vertices, *triangles;

/* Pixels in blocks of 4 x 2, each a packet: neighbours on the screen. */
enum { BLOCK_WIDTH = 4, BLOCK_HEIGHT = 2 };

struct packet {
    float origin[3][8], segment[3][8];
    int asked[8];
};

static struct packet *packets;
static size_t packet_count;

static void *read_file(const char *folder, const char *name, size_t bytes) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    void *content = malloc(bytes + 1);
    if (!file || !content) fail(path, "can't be opened");
    if (fread(content, 1, bytes, file) != bytes) fail(path, "is too short");
    fclose(file);
    return content;
}

static size_t pixel_of(size_t packet, int lane) {
    size_t a_row = width / BLOCK_WIDTH;
    size_t x = packet % a_row * BLOCK_WIDTH + lane % BLOCK_WIDTH;
    size_t y = packet / a_row * BLOCK_HEIGHT + lane / BLOCK_WIDTH;
    return y * width + x;
}

static void read_folder(const char *folder) {
    char path[4096];
    snprintf(path, sizeof path, "%s/counts.txt", folder);
    FILE *file = fopen(path, "r");
    if (!file) fail(path, "can't be opened");
    const char *form = "vertices %zu triangles %zu width %zu height %zu";
    if (fscanf(file, form, &vertex_count, &triangle_count, &width, &height) != 4) fail(path, "is not as expected");
    fclose(file);
    if (width % BLOCK_WIDTH || height % BLOCK_HEIGHT) fail(path, "the image is not of whole blocks");

    vertices = read_file(folder, "vertices.f32", vertex_count * 12);
    triangles = read_file(folder, "triangles.u32", triangle_count * 12);
    size_t pixels = width * height;
    /* A pixel: origin, segment. */
    float *rays = read_file(folder, "rays.f32", pixels * 24);
    uint8_t *asked = read_file(folder, "asked.u8", pixels);

    packet_count = pixels / 8;
    packets = malloc(packet_count * sizeof *packets);
    if (!packets) fail(path, "there is no memory for its rays");
    for (size_t p = 0; p < packet_count; p++)
        for (int lane = 0; lane < 8; lane++) {
            size_t pixel = pixel_of(p, lane);
            packets[p].asked[lane] = asked[pixel] ? -1 : 0;
            for (int axis = 0; axis < 3; axis++) {
                packets[p].origin[axis][lane] = rays[pixel * 6 + axis];
                packets[p].segment[axis][lane] = rays[pixel * 6 + 3 + axis];
            }
        }
    free(rays);
    free(asked);
}

/* The work. */

static void *device, *scene;
static int thread_count;
/* Bits of the rays of each packet that are hidden. */
static uint8_t *hidden;
/* Packets are taken in tasks, each by the thread that comes first. */
enum { TASK = 256 };
static atomic_size_t next_packet;

static double now_ms(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * 1e3 + time.tv_nsec * 1e-6;
}

static double build(void) {
    if (scene) release_scene(scene);
    scene = new_scene(device);
    void *mesh = new_geometry(device, GEOMETRY_TRIANGLE);
    /* The library's own buffers, as it reads some bytes beyond a vertex. Filling them isn't timed. */
    void *corners = new_buffer(mesh, BUFFER_VERTEX, 0, FORMAT_FLOAT3, 12, vertex_count);
    void *indices = new_buffer(mesh, BUFFER_INDEX, 0, FORMAT_UINT3, 12, triangle_count);
    if (!corners || !indices) fail("Embree", "has no memory for the triangles");
    memcpy(corners, vertices, vertex_count * 12);
    memcpy(indices, triangles, triangle_count * 12);
    double start = now_ms();
    commit_geometry(mesh);
    attach_geometry(scene, mesh);
    commit_scene(scene);
    double end = now_ms();
    release_geometry(mesh);
    if (device_error(device)) fail("Embree", "reports an error");
    return end - start;
}

static void trace_packet(size_t p, struct occluded_arguments *arguments) {
    struct rays rays;
    /* The library loads both whole, and so wants them aligned. */
    int asked[8] __attribute__((aligned(32)));
    memcpy(asked, packets[p].asked, sizeof asked);
    memcpy(rays.origin, packets[p].origin, sizeof rays.origin);
    memcpy(rays.direction, packets[p].segment, sizeof rays.direction);
    for (int lane = 0; lane < 8; lane++) {
        rays.tnear[lane] = 0;
        rays.tfar[lane] = 1;
        rays.time[lane] = 0;
        rays.mask[lane] = UINT32_MAX;
        rays.id[lane] = 0;
        rays.flags[lane] = 0;
    }
    occluded8(asked, scene, &rays, arguments);
    uint8_t bits = 0;
    for (int lane = 0; lane < 8; lane++) bits |= (asked[lane] && rays.tfar[lane] < 0) << lane;
    hidden[p] = bits;
}

static void *trace_tasks(void *unused) {
    /* Denormal numbers are zero, as operands and as results. */
    _mm_setcsr(_mm_getcsr() | 0x8040);
    struct occluded_arguments arguments = {.flags = QUERY_COHERENT, .features = FEATURES_ALL};
    size_t first;
    while ((first = atomic_fetch_add(&next_packet, TASK)) < packet_count)
        for (size_t p = first; p < first + TASK && p < packet_count; p++) trace_packet(p, &arguments);
    return unused;
}

static double trace(void) {
    pthread_t others[256];
    atomic_store(&next_packet, 0);
    double start = now_ms();
    for (int i = 1; i < thread_count; i++)
        if (pthread_create(&others[i], NULL, trace_tasks, NULL)) fail("a thread", "can't be started");
    trace_tasks(NULL);
    for (int i = 1; i < thread_count; i++) pthread_join(others[i], NULL);
    return now_ms() - start;
}

static void write_answers(const char *folder) {
    char path[4096];
    snprintf(path, sizeof path, "%s/hidden.u8", folder);
    uint8_t *bytes = malloc(width * height + 1);
    FILE *file = fopen(path, "wb");
    if (!file || !bytes) fail(path, "can't be written");
    for (size_t p = 0; p < packet_count; p++)
        for (int lane = 0; lane < 8; lane++) bytes[pixel_of(p, lane)] = hidden[p] >> lane & 1;
    if (fwrite(bytes, 1, width * height, file) != width * height || fclose(file)) fail(path, "can't be written");
    free(bytes);
}

int main(int count, char **arguments) {
    if (count != 4) fail("arguments", "LIBRARY FOLDER THREADS");
    open_library(arguments[1]);
    read_folder(arguments[2]);
    thread_count = atoi(arguments[3]);
    if (thread_count < 1 || thread_count > 256) fail(arguments[3], "is no number of threads from 1 to 256");
    hidden = calloc(packet_count + 1, 1);
    char settings[64];
    snprintf(settings, sizeof settings, "threads=%d", thread_count);
    device = new_device(settings);
    if (!device || !hidden) fail("Embree", "can't be started");
    int version = (int)device_property(device, PROPERTY_VERSION);
    const char *wide = device_property(device, PROPERTY_RAY16) ? "AVX-512" : "no AVX-512";
    printf("Embree %d.%d.%d, %s\n", version / 10000, version / 100 % 100, version % 100, wide);
    fflush(stdout);

    char line[64];
    while (fgets(line, sizeof line, stdin)) {
        int is_build = !strcmp(line, "build\n");
        if (!is_build && strcmp(line, "trace\n")) fail(line, "is neither build nor trace");
        if (!is_build && !scene) fail(line, "there is no scene to trace in yet");
        double taken = is_build ? build() : trace();
        if (!is_build) write_answers(arguments[2]);
        printf("%.6f\n", taken);
        fflush(stdout);
    }
    return 0;
}
