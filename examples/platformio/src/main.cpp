// Estimates one snapshot of the shoulder: on this machine (env:native) or a board with Arduino.
#include <shoulder.h>

static shoulder_t joint;
static const shoulder_counts_t counts = {{1500, 1200, 900}, {0, 0, 0}};

static bool estimate(shoulder_angles_t &angles) {
    return shoulder_init(&joint) == CCGEN_OK &&
           shoulder_estimate(&joint, &counts, &angles) == CCGEN_OK;
}

#ifdef ARDUINO
#include <Arduino.h>

void setup() {
    Serial.begin(115200);
}

void loop() {
    shoulder_angles_t angles;
    if (estimate(angles)) {
        for (int i = 0; i < SHOULDER_SEGMENTS; ++i) {
            Serial.println(angles.u[i]);
        }
    }
    delay(1000);
}
#else
#include <cstdio>

int main() {
    shoulder_angles_t angles;
    if (!estimate(angles)) {
        return 1;
    }
    for (int i = 0; i < SHOULDER_SEGMENTS; ++i) {
        std::printf("%d\n", angles.u[i]);
    }
    return 0;
}
#endif
