# kLargestEntry: entries of a direction whose largest entry was at most 1 before a pose turned it.
#
# Its length is at most √3, a pose off rigid by 1e-6 stretches it by as much, Double2 rounds by far less (r).
{ |r| <= 1b-90 -> sqrt(3)*(1 + 1e-6)*(1 + r) - @kLargestEntry@ <= 0 }
